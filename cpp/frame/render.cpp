// render (paper 3.2.4): calculators project their particles and send what is visible; the image generator draws it
// with the external objects.
#include "frame/engine.h"
#include "frame/work.h"

namespace motes::frame {
namespace {

image::Drawn drawn(const particles::Store& store) {
  image::Drawn d;
  d.count = store.size();
  for (std::size_t c = 0; c < 3; ++c) {
    d.position[c] = store.plane(particles::position, static_cast<int>(c));
    d.color[c] = store.plane(particles::color, static_cast<int>(c));
    d.color_of_all[c] = store.uniform_value(particles::color)[c];
  }
  d.alpha = store.plane(particles::alpha, 0);
  d.alpha_of_all = store.uniform_value(particles::alpha)[0];
  if (d.position[0] == nullptr) d.count = 0;  // no particle was ever here
  return d;
}

}  // namespace

void Engine::render() {
  if (!record_.view) return;
  if (calculator() >= 0) send_sprites();
  if (draws()) draw();
}

void Engine::send_sprites() {
  const Timed timed(*this, times_.render, "project");
  const double start = compute_seconds();
  comm::Message message;
  std::uint64_t visible = 0;
  work("render", [&] {
    for (const auto& system : systems_) {
      projector_.project(drawn(*system->store), system->sprite, *record_.view, records_);
      const auto bytes = records_.bytes();
      message.bytes().put(static_cast<std::uint64_t>(bytes.size()));
      message.bytes().put_raw(bytes.data(), bytes.size());
      visible += system->store->size();
    }
    if (!draws()) charge(options_.costs.record * static_cast<double>(visible));
  });
  slow_down(start);
  if (failure_.failed()) message = comm::Message();
  comm_->post(cast_.image_generator, comm::Phase::records, stamp(), std::move(message), visible, failure_.failed());
  if (options_.blocking) comm_->flush();
}

void Engine::draw() {
  const Timed timed(*this, times_.render, "draw");
  std::vector<comm::Message> messages;
  double particles = 0;
  for (const int from : cast_.calculators) {
    messages.push_back(comm_->expect(from, comm::Phase::records, stamp()));
    const auto count = static_cast<double>(messages.back().header().count);
    if (from != rank()) charge(options_.costs.collect * count);
    particles += count;
  }
  work("render", [&] {
    canvas_.begin(*record_.view, keep_linear_);
    for (const comm::Message& message : messages) {
      if (message.header().failed != 0) {
        throw std::runtime_error("a calculator could not draw its part of frame " + std::to_string(frame_));
      }
      for (particles::Reader in = message.reader(); !in.done();) canvas_.add(in.take(in.get<std::uint64_t>()));
    }
    pixels_ = canvas_.finish();
    charge(options_.costs.draw * particles + options_.costs.picture / options_.costs.scale);
  });
  // A frame that could not be drawn must not reach the script.
  if (failure_.failed()) std::rethrow_exception(own_exception_);
}

}  // namespace motes::frame
