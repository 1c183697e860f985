#include <cstring>
#include <exception>

#include "check.h"

// Runs all tests, or those whose name contains the first argument; exit code 1 where one failed.
int main(int count, char** words) {
  int ran = 0;
  for (const check::Test& test : check::tests()) {
    if (count > 1 && std::strstr(test.name, words[1]) == nullptr) continue;
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
