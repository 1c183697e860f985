#include "engine/session/session.h"

#include <utility>

namespace motes::engine {

Session::Session(std::unique_ptr<comm::Communicator> comm, roles::Cast cast)
    : comm_(std::move(comm)), cast_(std::move(cast)), relay_(*comm_, cast_) {}

void Session::give_up(Verdict verdict) {
  broken_ = true;
  const bool mine = verdict.failed_rank == rank() && failure_.kind == Failure::Kind::compute;
  failed_at_ = failure_.place;
  failure_ = {};
  const std::exception_ptr own = std::exchange(own_exception_, nullptr);
  if (mine && own) std::rethrow_exception(own);
  const std::string role = cast_.describe(verdict.failed_rank);
  const std::string who =
      "rank " + std::to_string(verdict.failed_rank) + " (" + role + "), frame " + std::to_string(frame);
  const std::string text = verdict.failure.kind == Failure::Kind::mismatch
                               ? who + ": its script differs from the other ranks': " + verdict.failure.text
                               : who + ", " + verdict.failure.action + ": " + verdict.failure.text;
  throw Agreed(std::move(verdict), frame, role, text);
}

void Session::rethrow() {
  if (!failure_.failed()) return;
  const std::exception_ptr own = std::exchange(own_exception_, nullptr);
  if (own) std::rethrow_exception(own);
  throw std::runtime_error(failure_.action + ": " + failure_.text);
}

void Session::check_alive() const {
  if (broken_) throw std::runtime_error("the run ended when frame " + std::to_string(frame) + " failed");
}

}  // namespace motes::engine
