#include "engine/render/shared_pictures.h"

#include <pthread.h>

#include <utility>

#include "base/memory.h"

namespace motes::engine {
namespace {

using base::kPage;
using base::whole_pages;

// Counts the forks of this process. A child keeps seeing the pictures that the script held at the fork, so these must
// not be drawn into again.
const std::atomic<std::uint64_t>& forks() {
  static std::atomic<std::uint64_t> count{0};
  static const int registered = ::pthread_atfork([] { ++count; }, [] { ++count; }, nullptr);
  static_cast<void>(registered);
  return count;
}

}  // namespace

void SharedPictures::interact(Rank& rank, std::size_t bytes, const RenderPlan& plan) {
  Session& session = rank.session;
  if (!session.comm().between_processes() || bytes > kLargest) return;
  if (bytes > bytes_) {
    bytes_ = bytes;
    memory_.reset();
    met_.assign(static_cast<std::size_t>(session.size()), false);
  }
  for (int other = 0; other < session.size(); ++other) {
    if (other == session.cast().image_generator || !plan.draws(other) || met_[static_cast<std::size_t>(other)])
      continue;
    met_[static_cast<std::size_t>(other)] = true;
    if (session.draws()) tell(rank, other);
    if (other == session.rank()) hear(rank);
  }
}

void SharedPictures::tell(Rank& rank, int to) {
  if (!memory_ && rank.settings.shares_pictures) {
    memory_ = comm::SharedMemory::make(memory_bytes());
    uses_ = std::make_shared<Uses>();
  }
  comm::Message message;
  message.bytes().put(memory_ ? memory_->address() : comm::SharedMemory::Address{});
  rank.session.comm().post(to, comm::Phase::memory, rank.session.stamp(), std::move(message));
}

void SharedPictures::hear(Rank& rank) {
  const Stopwatch::Phase phase(rank.watch, &PhaseTimes::render, "wait for memory");
  const Session& session = rank.session;
  const comm::Message message =
      rank.session.comm().expect(session.cast().image_generator, comm::Phase::memory, session.stamp());
  const auto address = message.reader().get<comm::SharedMemory::Address>();
  memory_ =
      address.bytes == memory_bytes() && rank.settings.shares_pictures ? comm::SharedMemory::open(address) : nullptr;
}

std::shared_ptr<std::uint8_t[]> SharedPictures::open(std::size_t bytes, comm::Stamp stamp) {
  if (!memory_ || bytes > bytes_) return nullptr;
  for (std::size_t i = 0; i < kPictures; ++i) {
    Use& use = (*uses_)[i];
    if (use.taken.exchange(true, std::memory_order_acquire)) continue;
    use.forks = forks();
    const auto give_back = [memory = memory_, uses = uses_, i](const std::uint8_t*) {
      Use& of = (*uses)[i];
      if (of.forks == forks()) of.taken.store(false, std::memory_order_release);
    };
    opened_ = sign_of(stamp);
    sign(i).store(opened_, std::memory_order_release);
    return {pixels(i), give_back};
  }
  return nullptr;
}

std::uint8_t* SharedPictures::find(comm::Stamp stamp) {
  for (std::size_t i = 0; memory_ && i < kPictures; ++i) {
    if (sign(i).load(std::memory_order_acquire) == sign_of(stamp)) return pixels(i);
  }
  return nullptr;
}

std::size_t SharedPictures::memory_bytes() const { return kPage + kPictures * whole_pages(bytes_); }

std::uint8_t* SharedPictures::pixels(std::size_t picture) {
  return reinterpret_cast<std::uint8_t*>(memory_->data() + kPage + picture * whole_pages(bytes_));
}

std::atomic_ref<std::uint64_t> SharedPictures::sign(std::size_t picture) {
  return std::atomic_ref<std::uint64_t>(reinterpret_cast<std::uint64_t*>(memory_->data())[picture]);
}

}  // namespace motes::engine
