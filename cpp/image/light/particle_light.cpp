#include "image/light/particle_light.h"

#include <algorithm>
#include <utility>

#include "base/vectors.h"
#include "image/camera.h"
#include "image/layout.h"
#include "image/mesh_corners.h"

namespace motes::image {
namespace {

ParticlePlanes particle_planes(const Drawn& d) {
  ParticlePlanes p{};
  for (std::size_t i = 0; i < 3; ++i) {
    p.position[i] = d.position[i];
    p.color[i] = d.color[i];
    p.color_of_all[i] = d.color_of_all[i];
  }
  p.alpha = d.alpha;
  p.alpha_of_all = d.alpha_of_all;
  p.size = d.size;
  p.size_of_all = d.size_of_all;
  return p;
}

void put_facing(const Drawn& d, LitShape& shape) {
  std::copy(d.velocity.begin(), d.velocity.end(), shape.velocity);
  std::copy(d.velocity_of_all.begin(), d.velocity_of_all.end(), shape.velocity_of_all);
  std::copy(d.orientation.begin(), d.orientation.end(), shape.orientation);
  std::copy(d.orientation_of_all.begin(), d.orientation_of_all.end(), shape.orientation_of_all);
}

LitShape::Kind lit_shape(const Sprite& sprite) {
  const auto* card = sprite.as<CardSprite>();
  if (card == nullptr || card->facing == Facing::camera) return LitShape::Kind::ball;
  return along_velocity(sprite) ? LitShape::Kind::card_along_velocity : LitShape::Kind::card;
}

void put_floats(const Vector& v, float* to) {
  for (std::size_t i = 0; i < 3; ++i) to[i] = static_cast<float>(v[i]);
}

}  // namespace

ParticleWidth particle_width(const Sprite& sprite, const View& view) {
  ParticleWidth width{};
  const float pixels = diameter_of(sprite, view.height);
  width.own = !(pixels > 0);
  width.per_metre = static_cast<float>(static_cast<double>(pixels) / lens(view).focal_px);
  put_floats(view.camera.position, width.eye);
  return width;
}

std::unique_ptr<const ParticleLight> ParticleLight::of(const Sprite& sprite, const View& view,
                                                       const ShadowGrids* shadows, InSight in_sight) {
  const bool obstacles = shadows != nullptr || in_sight;
  const bool lit = sprite.lit && (obstacles || !lit_by_painter(sprite));
  const bool fogged = view.fog.metres > 0 && !fogged_by_painter(sprite, view);
  if (!lit && !fogged) return nullptr;
  auto made = std::make_unique<ParticleLight>();
  LightTask& t = made->task_;
  t.width = particle_width(sprite, view);
  std::copy(view.fog.color.begin(), view.fog.color.end(), t.fog);
  t.fog_density = fogged ? 1 / view.fog.metres : 0;
  t.adds = sprite.blend == Sprite::Blend::add;
  if (lit) made->set_lighting(sprite, view, shadows, std::move(in_sight));
  return made;
}

void ParticleLight::set_lighting(const Sprite& sprite, const View& view, const ShadowGrids* shadows, InSight in_sight) {
  lit_ = true;
  in_sight_ = std::move(in_sight);
  Lighting& t = lighting_;
  t.shape.kind = lit_shape(sprite);
  t.relative = lit_by_painter(sprite);
  t.gains = image::has_gain(sprite, view);
  t.own_shadow = casts_sharply(sprite) ? 0 : sprite.shadow;
  if (sprite.is(Sprite::Kind::card)) t.reach = 0.7072f;
  if (sprite.is(Sprite::Kind::mesh)) t.reach = reach_of_mesh(sprite.asset());
  t.ambient = ambient(view);
  t.sky = shadows == nullptr ? nullptr : shadows->of_sky();
  t.sun = sun_of(view);
  t.sun_obstacles.shadow = shadows == nullptr ? nullptr : shadows->of_sun();
  for (std::size_t i = 0; i < view.lights.size(); ++i) {
    LightOnParticles light{lamp_of(view.lights[i]), {}};
    light.obstacles.shadow = shadows == nullptr ? nullptr : shadows->of_light(i);
    lights_.push_back(light);
  }
  t.lights = lights_.data();
  t.light_count = lights_.size();
}

void ParticleLight::light(const Drawn& particles, std::size_t first, std::size_t last, float* to,
                          std::size_t stride) const {
  LightTask task = task_;
  task.particles = particle_planes(particles);
  Lighting lighting = lighting_;
  put_facing(particles, lighting.shape);
  std::vector<float> parts;
  std::vector<LightOnParticles> lights;
  if (in_sight_) {
    parts.resize((1 + lights_.size()) * stride);
    in_sight_(task.particles, task.width, first, last, parts.data(), stride);
    lighting.sun_obstacles.in_sight = parts.data();
    lights = lights_;
    for (std::size_t k = 0; k < lights.size(); ++k) lights[k].obstacles.in_sight = parts.data() + (k + 1) * stride;
    lighting.lights = lights.data();
  }
  if (lit_) task.lighting = &lighting;
  float* const planes[4] = {to, to + stride, to + 2 * stride, to + 3 * stride};
  light_lanes().light(task, first, last, planes);
}

ParticleShadows::ParticleShadows(const Sprite& sprite, const View& view, const ShadowGrids& grids,
                                 const Drawn& particles)
    : task_{particle_planes(particles), particle_width(sprite, view), sprite.shadow}, grids_(&grids) {}

void ParticleShadows::add(std::size_t first, std::size_t last, std::int64_t* sums, std::vector<unsigned>& boxes) const {
  for (std::size_t light = 0; light < grids_->lights(); ++light) {
    boxes[light] |= light_lanes().add(task_, grids_->space(light), first, last, sums + light * ShadowGrids::numbers());
  }
}

}  // namespace motes::image
