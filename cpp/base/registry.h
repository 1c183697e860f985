// Content identified by its fingerprint, so that recorded lists and messages contain only the key: pictures, meshes,
// tables, ties. Kept content is immutable and stays until the process ends.
#pragma once

#include <cstdint>
#include <cstdio>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "base/bytes.h"
#include "base/fields.h"
#include "base/hash.h"

namespace motes::base {

/// The key of some content: equal content of one kind has an equal key, on every rank and in every run. 0: no content.
using ContentKey = std::uint64_t;

/// Returns the key of content; `bytes`: its fields.
using Fingerprint = ContentKey (*)(const char* kind, std::span<const std::byte> bytes);

/// Computes a key from the hash of records, which is fast enough for tables that change in each frame.
inline ContentKey fingerprint(const char* kind, std::span<const std::byte> bytes) {
  return mix(hash(std::as_bytes(std::span(std::string_view(kind)))).low ^ hash(bytes).low);
}

/// All content of one kind in this process. T has fields(), operator== and check(), which throws std::invalid_argument.
/// Thread-safe.
template <class T>
class Registry {
 public:
  /// `kind`: its name in errors, and part of the key: a picture never has the key of a mesh.
  explicit Registry(const char* kind, Fingerprint name = fingerprint) : kind_(kind), name_(name) {}

  /// Checks the content and keeps it; equal content is kept once.
  ContentKey keep(T content) {
    check(content);
    const ContentKey key = key_of(content);
    const std::scoped_lock lock(mutex_);
    std::shared_ptr<const T>& kept = all_[key];
    if (kept == nullptr) {
      kept = std::make_shared<const T>(std::move(content));
    } else if (!(*kept == content)) {
      throw std::runtime_error(std::string("two different ") + kind_ + "s have the key " + text(key) +
                               ": change one of them");
    }
    return key;
  }

  /// Returns the content with this key, or null if this process does not keep it.
  std::shared_ptr<const T> find(ContentKey key) {
    const std::scoped_lock lock(mutex_);
    const auto found = all_.find(key);
    return found == all_.end() ? nullptr : found->second;
  }

  /// Returns the content with this key. Throws std::invalid_argument if this process does not keep it.
  std::shared_ptr<const T> get(ContentKey key) {
    auto found = find(key);
    if (found == nullptr) throw std::invalid_argument(std::string("no ") + kind_ + " has the key " + text(key));
    return found;
  }

  /// Writes the content of these keys as bytes, for files.
  void write(const std::set<ContentKey>& keys, Bytes& out) {
    out.put(static_cast<std::uint32_t>(keys.size()));
    for (const ContentKey key : keys) write_fields(*get(key), out);
  }

  /// Keeps what write() wrote. Throws std::runtime_error if the bytes are damaged.
  void read(Reader& in) {
    for (auto left = in.get<std::uint32_t>(); left > 0; --left) {
      T content;
      read_fields(in, content);
      try {
        keep(std::move(content));
      } catch (const std::invalid_argument& error) {
        throw std::runtime_error(std::string("damaged bytes: ") + kind_ + ": " + error.what());
      }
    }
  }

 private:
  ContentKey key_of(const T& content) const {
    Bytes bytes;
    write_fields(content, bytes);
    const ContentKey key = name_(kind_, bytes.view());
    return key == 0 ? 1 : key;
  }

  static std::string text(ContentKey key) {
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(key));
    return digits;
  }

  const char* kind_;
  Fingerprint name_;
  std::mutex mutex_;
  std::map<ContentKey, std::shared_ptr<const T>> all_;
};

}  // namespace motes::base
