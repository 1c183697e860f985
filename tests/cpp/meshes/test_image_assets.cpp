// Pictures and meshes: kept once, identified by their content, written to files and read back.
#include "meshes/assets.h"

#include <cmath>
#include <thread>

#include "support/check.h"

namespace motes::test_image_assets {
using namespace meshes;
using base::Bytes;
using base::Reader;

namespace {

meshes::Picture checkered(std::uint8_t shade) { return {2, 1, {shade, 0, 0, 255, 0, shade, 0, 128}}; }
meshes::Mesh corner(float size) { return {{0, 0, 0, size, 0, 0, 0, size, 0}, {0, 1, 2}}; }

}  // namespace

TEST(image_assets_are_named_by_their_content) {
  const meshes::AssetKey first = keep(checkered(1)), second = keep(checkered(2));
  CHECK(first != 0 && second != 0 && first != second);
  CHECK(meshes::keep(checkered(1)) == first);
  CHECK(meshes::picture(first)->rgba[0] == 1);
  CHECK(meshes::picture(first) == meshes::picture(meshes::keep(checkered(1))));
  const meshes::AssetKey third = keep(corner(1));
  CHECK(meshes::has_mesh(third) && !meshes::has_picture(third) && meshes::has_picture(first) &&
        !meshes::has_mesh(first));
  CHECK_THROWS(meshes::picture(third), std::invalid_argument);
  CHECK_THROWS(meshes::mesh(12345), std::invalid_argument);
}

// The key is the same in every run and on every machine: recorded lists are compared by it.
TEST(image_assets_keep_their_key_for_ever) {
  CHECK(meshes::keep(checkered(7)) == 0xa00967afad577ac7u);
  CHECK(meshes::keep(corner(7)) == 0x530cba4aee5b6468u);
  meshes::Mesh colored = corner(7);
  colored.colors = {1, 0, 0, 0, 1, 0, 0, 0, 0};  // ends with zeros
  CHECK(meshes::keep(colored) == 0xe2050a9451da3258u);
  meshes::Mesh uneven = corner(7);
  uneven.density = {1, 0, 0};
  CHECK(meshes::keep(uneven) != meshes::keep(corner(7)));
}

TEST(image_assets_are_checked) {
  CHECK_THROWS(meshes::keep(meshes::Picture{0, 1, {}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Picture{2, 2, {1, 2, 3, 4}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Picture{meshes::kMaxPicture + 1, 1, {}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, 0, 0}, {}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, 0}, {0, 0, 0}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, 0, 0}, {0, 0, 1}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, 0, 0}, {0, 0}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, std::nanf(""), 0}, {0, 0, 0}}), std::invalid_argument);
  CHECK_THROWS(meshes::keep(meshes::Mesh{{0, HUGE_VALF, 0}, {0, 0, 0}}), std::invalid_argument);
  for (const std::vector<float>& density :
       std::vector<std::vector<float>>{{1, 1}, {0, 0, 0}, {1, -1, 1}, {1, std::nanf(""), 1}, {1, HUGE_VALF, 1}}) {
    meshes::Mesh mesh = corner(1);
    mesh.density = density;
    CHECK_THROWS(meshes::keep(mesh), std::invalid_argument);
  }
}

TEST(image_assets_go_through_a_file) {
  const meshes::AssetKey first = keep(checkered(3)), second = keep(corner(3));
  Bytes bytes;
  meshes::write_assets({first, second}, bytes);
  Reader in(bytes.view());
  meshes::read_assets(in);
  CHECK(in.done());
  CHECK(*meshes::picture(first) == checkered(3) && *meshes::mesh(second) == corner(3));
  CHECK_THROWS(meshes::write_assets({99}, bytes), std::invalid_argument);
}

TEST(image_assets_from_damaged_files_are_refused) {
  Bytes bytes;
  meshes::write_assets({meshes::keep(corner(4))}, bytes);
  const std::uint32_t far_vertex = 77;
  bytes.set(bytes.size() - 4, far_vertex);  // the last index
  Reader in(bytes.view());
  CHECK_THROWS(meshes::read_assets(in), std::runtime_error);
  Reader cut(bytes.view().first(bytes.size() - 1));
  CHECK_THROWS(meshes::read_assets(cut), std::runtime_error);
}

TEST(image_assets_may_be_kept_by_several_threads) {
  std::vector<std::thread> threads;
  std::vector<meshes::AssetKey> keys(4);
  for (meshes::AssetKey& key : keys) {
    threads.emplace_back([&key] {
      for (int i = 0; i < 50; ++i) key = keep(corner(static_cast<float>(100 + i)));
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const meshes::AssetKey key : keys) CHECK(key == keys[0] && meshes::mesh(key)->vertices[3] == 149);
}

}  // namespace motes::test_image_assets
