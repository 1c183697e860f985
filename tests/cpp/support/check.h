// The few macros that the C++ unit tests need: TEST(name) { CHECK(x == y); CHECK_THROWS(f(), std::invalid_argument); }
#pragma once

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

namespace check {

struct Test {
  const char* name;
  const char* file;
  std::function<void()> body;
};

inline std::vector<Test>& tests() {
  static std::vector<Test> all;
  return all;
}

inline int& failures() {
  static int count = 0;
  return count;
}

inline bool add(const char* name, const char* file, std::function<void()> body) {
  tests().push_back({name, file, std::move(body)});
  return true;
}

inline void fail(const char* file, int line, const std::string& what) {
  ++failures();
  std::fprintf(stderr, "%s:%d: failed: %s\n", file, line, what.c_str());
}

inline std::string text(double value) {
  char digits[32];
  std::snprintf(digits, sizeof digits, "%.9g", value);
  return digits;
}

}  // namespace check

#define TEST(name)                                                           \
  static void test_##name();                                                 \
  static const bool added_##name = check::add(#name, __FILE__, test_##name); \
  static void test_##name()

#define CHECK(condition)                                           \
  do {                                                             \
    if (!(condition)) check::fail(__FILE__, __LINE__, #condition); \
  } while (false)

#define CHECK_NEAR(a, b, tolerance)                                                                       \
  do {                                                                                                    \
    const double left_ = (a), right_ = (b);                                                               \
    if (!(left_ - right_ <= (tolerance) && right_ - left_ <= (tolerance)))                                \
      check::fail(__FILE__, __LINE__,                                                                     \
                  std::string(#a " near " #b ": ") + check::text(left_) + " and " + check::text(right_)); \
  } while (false)

#define CHECK_THROWS(expression, exception)                                           \
  do {                                                                                \
    bool thrown_ = false;                                                             \
    try {                                                                             \
      (void)(expression);                                                             \
    } catch (const exception&) {                                                      \
      thrown_ = true;                                                                 \
    }                                                                                 \
    if (!thrown_) check::fail(__FILE__, __LINE__, #expression " throws " #exception); \
  } while (false)
