#include "tests/simulation/udp/topic.h"

#include <algorithm>

#include "core/seam/gate.h"

namespace sft::simulation {

namespace {

/// Null: the sample is a union of masks, or of something that nobody asks for.
const Selection* named_by(const core::SampleBuffer& sample) {
  if (sample.merged) return nullptr;
  const auto named = std::ranges::find_if(wishes(), [&](const Selection& wish) {
    return wish.mask() == sample.mask && wish.parts_hash() == sample.parts &&
           core::gate_id(wish.gate_hash(), 0) == sample.gate;
  });
  return named == wishes().end() ? nullptr : &*named;
}

}  // namespace

const std::vector<Selection>& wishes() {
  static const std::vector<Selection> all = [] {
    std::vector<Selection> made;
    for (const char* text : {"*", "data", "stamp, width", "data[:100]", "data[50:5000], height",
                             "data[::3], stamp", "* @ every 2nd", "data[:100] @ every 2nd",
                             "data[::3] @ changed(height) 9", "data[10:], name @ every 3rd or height < 500"})
      made.push_back(image_type().closed(image_type().parse_selection(text).value()));
    return made;
  }();
  return all;
}

std::uint64_t name_of_selection(const core::SampleBuffer& sample) {
  if (sample.merged) return sample.mask.hash();
  const Selection* named = named_by(sample);
  return named == nullptr ? 0 : named->hash();
}

std::vector<std::byte> body_under(const Image& image, const core::SampleBuffer& sample) {
  const Selection* const named = named_by(sample);
  const std::size_t leaf = *udp::test::fields<Image>("data").begin();
  const Selection::Part* const part = named == nullptr ? nullptr : named->part(leaf);
  if (part == nullptr) return udp::test::encoded_body(image, sample.mask);
  Image cut = image;
  cut.data.clear();
  const std::size_t end = std::min<std::size_t>(part->columns.end, image.data.size());
  for (std::size_t i = part->columns.begin; i < end; i += part->columns.step)
    cut.data.push_back(image.data[i]);
  return udp::test::encoded_body(cut, sample.mask);
}

}  // namespace sft::simulation
