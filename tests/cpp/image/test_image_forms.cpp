// Meshes, cards and ribbons that turn, or are out of focus: the same with every instruction set, and inside the tile.
#include <algorithm>
#include <utility>

#include "image/layout.h"
#include "image/project/projector.h"
#include "image/test_image_wide_scene.h"
#include "meshes/assets.h"
#include "support/check.h"

namespace motes::test_image_forms {
using namespace image_test;

namespace {

meshes::AssetKey wedge() {
  meshes::Mesh mesh;
  mesh.vertices = {-1, -1, -1, 1, -1, -0.5F, 0, 1, -1, 0, 0, 1.5F};
  mesh.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
  return meshes::keep(std::move(mesh));
}

Sprite form(Kind kind, Blend blend) {
  Sprite s = wide_sprite(kind, blend);
  if (kind == Kind::mesh) s.look = MeshSprite{wedge()};
  if (kind == Kind::card) s.look = CardSprite{{two_colors()}};
  if (kind == Kind::ribbon) s.look = RibbonSprite{0.5F, 1};
  return s;
}

// Particles that fill the view and more, some of them around the camera, with planes of all that forms need.
struct Forms {
  static constexpr std::size_t kCount = 60, kRoom = kCount + 16;
  std::vector<float> plane[14];
  std::vector<float> past[3], past_count;

  explicit Forms(std::uint64_t seed) {
    test::Dice dice(seed);
    const auto fill = [&](std::vector<float>& to, float low, float high) {
      to.resize(kRoom);
      for (float& v : to) v = dice.between(low, high);
    };
    for (std::size_t k = 0; k < 14; ++k) {
      const float most = k < 3 ? 4.0F : k < 7 ? 1.0F : 30.0F;
      fill(plane[k], -most, most);
    }
    for (std::size_t i = 0; i < kCount; i += 7) plane[2][i] = 9.6F;  // almost in the camera
    fill(plane[13], 0.01F, 1.5F);
    for (std::vector<float>& p : past) fill(p, -4, 4);
    past_count.assign(kRoom, 1);
  }
  Drawn drawn() const {
    Drawn d;
    d.count = kCount;
    for (std::size_t c = 0; c < 3; ++c) {
      d.position[c] = plane[c].data();
      d.spin[c] = plane[7 + c].data();
      d.velocity[c] = plane[10 + c].data();
      d.past[0].position[c] = past[c].data();
    }
    for (std::size_t c = 0; c < 4; ++c) d.orientation[c] = plane[3 + c].data();
    d.size = plane[13].data();
    d.past[0].age = 1;
    d.past_count = past_count.data();
    d.color_of_all = {0.3F, 0.6F, 0.9F};
    d.alpha_of_all = 0.7F;
    return d;
  }
};

View lens_view(double aperture, float shutter) {
  View view = wide_view(100, 90);
  view.camera.focus = 8;
  view.camera.aperture = aperture;
  view.shutter = shutter;
  return view;
}

Projection moving() {
  Projection projection;
  projection.dt = 0.04;
  projection.any_depth = true;
  return projection;
}

TEST(image_forms_in_motion_and_out_of_focus_do_not_depend_on_the_isa) {
  const Forms forms(5);
  const auto projects = test::runnable<ProjectWideLanes>(MOTES_BUILDS(project_wide_lanes));
  const auto splats = usable_splat_lanes();
  const auto wides = usable_wide_lanes();
  for (const Kind kind : {Kind::card, Kind::mesh, Kind::ribbon}) {
    for (const Blend blend : {Blend::add, Blend::alpha, Blend::opaque}) {
      for (const double aperture : {0.0, 0.5}) {
        const View view = lens_view(aperture, 0.8F);
        const Sprite sprite = as_seen(form(kind, blend), view);
        const auto bytes = projected(forms.drawn(), sprite, view, moving(), project_lanes(), *projects.front());
        for (const auto* lanes : projects)
          CHECK(projected(forms.drawn(), sprite, view, moving(), project_lanes(), *lanes) == bytes);
        const RecordsView records(bytes);
        const Brush brush(records.sprite(), records.layout(), view, records.colored());
        for (int tile = 0; tile < records.grid().tiles(); ++tile) {
          const RecordsView::RecordRun piece = records.piece(records.batches()[0], tile);
          const std::vector<Piece> pieces{{&brush, piece.records, piece.count}};
          PaintedTile first(view, tile, *splats[0], *wides[0]);
          const std::vector<float> reference = first.paint(pieces);
          for (std::size_t isa = 1; isa < wides.size(); ++isa) {
            PaintedTile other(view, tile, *splats[isa], *wides[isa]);
            CHECK(other.paint(pieces) == reference);
          }
          CHECK(*std::max_element(reference.begin(), reference.end()) > 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace motes::test_image_forms
