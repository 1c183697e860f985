// SHA-256 against the known answers of the FIPS 180-4 examples and NIST's vectors, in one piece and in many.
#include <algorithm>
#include <string>
#include <vector>

#include "base/sha256.h"
#include "support/check.h"

namespace motes::test_sha256 {
using base::Sha256;

namespace {

std::string sha256(const std::string& text) {
  Sha256 sum;
  sum.add(text);
  return sum.finish();
}

}  // namespace

TEST(sha256_known_answers) {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(sha256_in_pieces_of_any_size) {
  std::string text;
  for (int i = 0; i < 300; ++i) text += static_cast<char>(i * 37);
  for (std::size_t length = 0; length <= text.size(); ++length) {
    const std::string whole = sha256(text.substr(0, length));
    Sha256 parts;
    for (std::size_t at = 0, step = 1; at < length; at += step, step = step % 67 + 3) {
      parts.add(text.substr(at, std::min(step, length - at)));
    }
    CHECK(parts.finish() == whole);
  }
}

TEST(picture_sha256_has_the_shape_in_it) {
  const std::vector<std::uint8_t> pixels(2 * 3 * 3, 7);
  const std::string text = "2x3x3\n" + std::string(18, '\7');
  CHECK(base::picture_sha256(3, 2, pixels) == sha256(text));
  CHECK(base::picture_sha256(2, 3, pixels) != sha256(text));
}

}  // namespace motes::test_sha256
