#include "image/project/records.h"

#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "base/enumerators.h"
#include "base/fields.h"

namespace motes::image {
namespace {

static_assert(std::endian::native == std::endian::little, "messages are little-endian");

std::uint32_t word_at(const std::byte* from, std::size_t index) {
  std::uint32_t word;
  std::memcpy(&word, from + 4 * index, sizeof word);
  return word;
}

[[noreturn]] void refuse(const std::string& why) { throw std::runtime_error("image records: " + why); }

}  // namespace

RecordsView::RecordsView(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof head_) refuse("message is too short");
  std::memcpy(&head_, bytes.data(), sizeof head_);
  check_head();
  std::span<const std::byte> rest = bytes.subspan(sizeof head_);
  take_sprite(rest);
  grid_ = {head_.width, head_.height};
  const auto tiles = static_cast<std::uint32_t>(grid_.tiles());
  if (head_.first_slot > tiles || head_.slots > tiles - head_.first_slot) refuse("impossible range of slots");
  if (head_.batches > rest.size() / 4) refuse("message ends too early");
  batches_.reserve(head_.batches);
  for (std::uint32_t i = 0; i < head_.batches; ++i) batches_.push_back(take_batch(rest));
  if (!rest.empty() || count_ != head_.records) refuse("sizes do not agree");
}

void RecordsView::check_head() const {
  if (head_.magic != RecordsHead::kMagic) refuse("not a message of records");
  if (head_.width < 1 || head_.width > kMaxSize || head_.height < 1 || head_.height > kMaxSize) {
    refuse("impossible image size " + std::to_string(head_.width) + "x" + std::to_string(head_.height));
  }
  if (head_.layout >= base::enumerators<Layout>() || head_.with_velocity > 1 || head_.colored > 1) {
    refuse("unknown layout");
  }
}

void RecordsView::take_sprite(std::span<const std::byte>& rest) {
  if (head_.sprite_bytes > rest.size()) refuse("message ends too early");
  sprite_bytes_ = rest.first(head_.sprite_bytes);
  rest = rest.subspan(head_.sprite_bytes);
  base::Reader in(sprite_bytes_);
  try {
    base::read_fields(in, sprite_);
    check_common(sprite_);
  } catch (const std::exception& error) {
    refuse(std::string("unknown sprite: ") + error.what());
  }
  if (in.left() >= RecordsHead::kAligned) refuse("a sprite of the wrong length");
  if (sprite_.sheet() != nullptr && !valid(sprite_.sheet()->tiles)) refuse("impossible tiles");
  if ((form(layout()).tile != 0) != sprite_.tiled()) refuse("impossible tiles");
  const bool blends_alpha = sprite_.blend == Sprite::Blend::alpha;
  if (!colored() && (blends_alpha || !may_lack_color(layout()))) refuse("colours are missing");
  const float diameter = diameter_of(sprite_, head_.height);
  if (of_fixed_size(layout()) && !(diameter >= 2 && diameter <= static_cast<float>(kMaxFootprint)))
    refuse("a sprite that does not fit its layout");
}

RecordsView::Batch RecordsView::take_batch(std::span<const std::byte>& rest) {
  const std::size_t slots = head_.slots;
  const std::size_t offset_bytes = 4 * (slots + 1);
  if (rest.size() < offset_bytes) refuse("message ends too early");
  const Batch batch{rest.data(), rest.data() + offset_bytes};
  std::uint32_t before = 0;
  bool ascending = word_at(batch.offsets, 0) == 0;
  for (std::size_t s = 1; s <= slots; ++s) {
    const std::uint32_t offset = word_at(batch.offsets, s);
    ascending &= offset >= before;
    before = offset;
  }
  if (!ascending) refuse("offsets are not ascending");
  const std::size_t total = static_cast<std::size_t>(before) * record_bytes();
  if (rest.size() - offset_bytes < total) refuse("message ends too early");
  rest = rest.subspan(offset_bytes + total);
  count_ += before;
  return batch;
}

RecordsView::RecordRun RecordsView::piece(const Batch& batch, int slot) const {
  const std::size_t s = static_cast<std::uint32_t>(slot) - head_.first_slot;
  if (slot < 0 || s >= head_.slots) return {batch.records, 0};
  const std::uint32_t first = word_at(batch.offsets, s);
  return {batch.records + first * record_bytes(), word_at(batch.offsets, s + 1) - first};
}

std::size_t RecordsView::count(int first, int end) const {
  const std::size_t from = static_cast<std::uint32_t>(first) - head_.first_slot;
  const std::size_t to = static_cast<std::uint32_t>(end) - head_.first_slot;
  std::size_t count = 0;
  for (const Batch& batch : batches_) count += word_at(batch.offsets, to) - word_at(batch.offsets, from);
  return count;
}

void RecordsView::add_counts(std::span<std::uint32_t> counts) const {
  const std::span<std::uint32_t> here = counts.subspan(head_.first_slot, head_.slots);
  for (const Batch& batch : batches_) {
    for (std::size_t s = 0; s < here.size(); ++s) here[s] += word_at(batch.offsets, s + 1) - word_at(batch.offsets, s);
  }
}

void RecordsView::append_part(int first, int end, base::Bytes& out) const {
  const int here = static_cast<int>(head_.first_slot);
  if (first < here || end < first || end > here + static_cast<int>(head_.slots)) {
    throw std::invalid_argument("image records: slots that are not in the message");
  }
  RecordsHead head = head_;
  head.first_slot = static_cast<std::uint32_t>(first);
  head.slots = static_cast<std::uint32_t>(end - first);
  head.batches = 0;
  head.records = count(first, end);
  const auto from = static_cast<std::size_t>(first - here), to = static_cast<std::size_t>(end - here);
  const std::size_t offset_bytes = 4 * (to - from + 1);
  const std::size_t at = out.size();
  out.reserve(at + sizeof head + sprite_bytes_.size() + batches_.size() * offset_bytes + head.records * record_bytes());
  out.put_raw(&head, sizeof head);
  out.put_raw(sprite_bytes_.data(), sprite_bytes_.size());
  for (const Batch& batch : batches_) {
    const std::uint32_t before = word_at(batch.offsets, from);
    const std::size_t records = word_at(batch.offsets, to) - before;
    if (records == 0) continue;
    std::byte* offsets = out.extend(offset_bytes);
    for (std::size_t s = from; s <= to; ++s, offsets += 4) {
      const std::uint32_t offset = word_at(batch.offsets, s) - before;
      std::memcpy(offsets, &offset, 4);
    }
    out.put_raw(batch.records + before * record_bytes(), records * record_bytes());
    ++head.batches;
  }
  out.set(at, head);
}

}  // namespace motes::image
