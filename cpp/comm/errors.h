// Errors between ranks.
#pragma once

#include <stdexcept>
#include <string>

namespace motes::comm {

/// The transport failed, or a message was not the one that the protocol expects.
class CommError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A rank did not answer within the stall limit.
class Stalled : public CommError {
 public:
  Stalled(int rank, const std::string& text) : CommError(text), rank_(rank) {}
  /// Returns the rank that was waited for; -1: several.
  int rank() const { return rank_; }

 private:
  int rank_;
};

/// The process of a rank is gone, and the other ranks can continue without it: see Transport::survives.
class RankLost : public CommError {
 public:
  /// `rank`: the lost rank; -1 if unknown.
  explicit RankLost(int rank)
      : CommError((rank < 0 ? "another rank" : "rank " + std::to_string(rank)) +
                  " is lost: its process was killed or has crashed"),
        rank_(rank) {}
  int rank() const { return rank_; }

 private:
  int rank_;
};

}  // namespace motes::comm
