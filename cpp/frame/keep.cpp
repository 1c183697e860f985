// Keeping what a script says: its lists become a scene file. Nobody needs the particles for that, so with one rank
// they are not computed; where the script asks for them after all, the kept lists are replayed first.
#include "frame/engine.h"
#include "frame/replay.h"

namespace motes::frame {

void Engine::keep_lists(bool compute) {
  keeping_ = true;
  pictures_ = compute;
  listing_ = !compute && comm_->size() == 1;
}

void Engine::keep_list() {
  if (!keeping_) return;
  kept_.emplace_back();
  kept_.back().put_raw(record_bytes_.data(), record_bytes_.size());
  if (!pictures_) record_.view.reset();
}

void Engine::catch_up() {
  if (!listing_) return;
  listing_ = false;
  const std::vector<std::unique_ptr<System>> as_they_are = std::move(systems_);
  systems_.clear();
  for (const auto& s : as_they_are) add_system(s->definition);
  frame_ = 0;
  keeping_ = false;  // these are kept already
  for (const particles::Bytes& bytes : kept_) {
    particles::Reader in(bytes.view());
    replay(*this, recording::read(in), false);
  }
  keeping_ = true;
  for (std::size_t i = 0; i < as_they_are.size(); ++i) {
    systems_[i]->sprite = as_they_are[i]->sprite;
    for (recording::Item& item : as_they_are[i]->list) record(static_cast<int>(i), std::move(item));
  }
}

}  // namespace motes::frame
