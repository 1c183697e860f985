#include <cstdlib>
#include <cstring>
#include <exception>

#include "support/check.h"

namespace {

// Returns whether to run a test. "2/3": every third test, from the second one on; "tests/cpp/image" or any word with a
// slash: tests in files whose paths contain it; any other word: tests whose names contain it.
bool wanted(const char* word, int number, const check::Test& test) {
  char* slash = nullptr;
  const long part = std::strtol(word, &slash, 10);
  const long parts = *slash == '/' ? std::strtol(slash + 1, nullptr, 10) : 0;
  if (parts > 0) return number % parts == part - 1;
  return std::strstr(std::strchr(word, '/') != nullptr ? test.file : test.name, word) != nullptr;
}

}  // namespace

// Runs all tests, or those that the first argument selects. Returns 1 if one failed.
int main(int count, char** words) {
  int ran = 0, number = 0;
  for (const check::Test& test : check::tests()) {
    if (count > 1 && !wanted(words[1], number++, test)) continue;
    ++ran;
    const int before = check::failures();
    try {
      test.body();
    } catch (const std::exception& error) {
      check::fail(test.name, 0, std::string("unexpected exception: ") + error.what());
    }
    std::printf("%s %s\n", check::failures() == before ? "ok    " : "FAILED", test.name);
  }
  std::printf("%d tests, %d failed checks\n", ran, check::failures());
  return check::failures() == 0 && ran > 0 ? 0 : 1;
}
