// Recorded lists with shapes of every kind: reading gives what was written, and broken bytes are refused.
#include <stdexcept>
#include <vector>

#include "recording/record.h"
#include "support/check.h"

namespace motes::test_record_shapes {
namespace {

using actions::Action;
using recording::Record;
using shapes::Kind;
using shapes::Shape;

Record record_with(const Shape& shape) {
  Action sink;
  sink.kind = actions::Kind::sink;
  sink.numbers = {1};
  sink.shapes = {shape};
  recording::Burst burst;
  burst.shape = shape;
  Record record;
  record.systems.resize(1);
  record.lists = {{burst, sink}};
  record.sprites.resize(1);
  return record;
}

Record again(const Record& record) {
  base::Bytes bytes;
  recording::write(record, bytes);
  base::Reader reader(bytes.view());
  return recording::read(reader);
}

const std::vector<Shape> kShapes = {{Kind::triangle, {0, 0, 0, 1, 0, 0, 0, 1, 0}},
                                    {Kind::cylinder, {0, 0, 0, 1, 0, 0, 2, 1}},
                                    {Kind::cone, {0, 0, 0, 1, 0, 0, 2, 1}},
                                    {Kind::blob, {0, 0, 0, 1}},
                                    {Kind::sphere, {0, 0, 0, 2, 1}}};

}  // namespace

TEST(recorded_shapes_come_back) {
  std::vector<Shape> all = kShapes;
  all.push_back(shapes::unite(kShapes));
  for (const Shape& shape : all) {
    const Record record = record_with(shape);
    const Record read = again(record);
    CHECK(read == record);
    const auto& found = std::get<Action>(read.lists[0][1]).shapes[0];
    CHECK(found == shape && found.parts == shape.parts);
    for (int i = 0; i < found.parts; ++i) CHECK(found.part[i].upto == shape.part[i].upto);
  }
}

TEST(unions_differ_by_their_parts) {
  const Shape two = shapes::unite({kShapes[0], kShapes[1]});
  const Shape other = shapes::unite({kShapes[0], kShapes[2]});
  CHECK(two == shapes::unite({shapes::unite({kShapes[0]}), kShapes[1]}));
  CHECK(!(two == other) && !(two == kShapes[0]) && !(two == shapes::unite({kShapes[0]})));
  CHECK(!recording::first_difference(record_with(two), record_with(other)).empty());
  CHECK_THROWS(shapes::unite({}), std::invalid_argument);
}

TEST(broken_unions_are_refused) {
  base::Bytes bytes;
  recording::write(record_with(shapes::unite({kShapes[4]})), bytes);
  std::vector<std::byte> raw(bytes.view().begin(), bytes.view().end());
  std::size_t refused = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    if (raw[i] != static_cast<std::byte>(Kind::sphere)) continue;
    std::vector<std::byte> broken = raw;
    broken[i] = static_cast<std::byte>(Kind::united);  // a union in a union
    base::Reader reader(broken);
    try {
      recording::read(reader);
    } catch (const std::runtime_error&) {
      ++refused;
    }
  }
  CHECK(refused >= 2);
}

}  // namespace motes::test_record_shapes
