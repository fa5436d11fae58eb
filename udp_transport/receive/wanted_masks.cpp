#include "udp_transport/receive/wanted_masks.h"

#include <algorithm>
#include <utility>

#include "sft/type_support.h"

namespace sft::udp {

namespace {
bool equals(const FieldMask& mask, std::span<const std::byte> words) {
  for (std::size_t i = 0; i < mask.words(); ++i) {
    if (mask.word(i) != load_word(&words[i * sizeof(std::uint64_t)])) return false;
  }
  return true;
}
}  // namespace

void WantedMasks::set(const TypeSupport& type, std::span<const Selection> selections) {
  type_ = &type;
  wanted_.clear();
  merged_.clear();
  for (const Selection& selection : selections)
    wanted_.push_back(
        {selection.mask(), selection.hash(), selection.parts_hash(), selection.without_rate().gate_hash()});
  std::ranges::sort(wanted_, {}, &Wanted::hash);
}

WantedMasks::Named WantedMasks::named_by(Datagram& d) {
  std::span<const std::byte> words;
  if ((d.first.flags & mask_words_follow) != 0) {
    const std::size_t bytes = (type_->leaves() + 63) / 64 * sizeof(std::uint64_t);
    if (type_->leaves() <= 64 || d.payload.size() < bytes) return {.malformed = true};
    words = d.payload.first(bytes);
    d.payload = d.payload.subspan(bytes);
    if (d.kind == DatagramKind::whole) d.first.total = static_cast<std::uint32_t>(d.payload.size());
  }
  if ((d.first.flags & merged_masks) != 0) return merged(d, words);
  const auto of_hash = std::ranges::equal_range(wanted_, d.first.mask, {}, &Wanted::hash);
  const auto found =
      std::ranges::find_if(of_hash, [&](const Wanted& w) { return words.empty() || equals(w.mask, words); });
  if (found == of_hash.end()) return {};
  return {.mask = &found->mask, .parts = found->parts, .conditions = found->conditions};
}

/// Returns the union of masks that the datagram names, if the union contains a mask that a reader requests.
WantedMasks::Named WantedMasks::merged(const Datagram& d, std::span<const std::byte> words) {
  const auto known = std::ranges::find_if(merged_, [&](const FieldMask& mask) {
    return mask.hash() == d.first.mask && (words.empty() || equals(mask, words));
  });
  if (known != merged_.end()) return {.mask = &*known};
  if (words.empty() != (type_->leaves() <= 64)) return {.malformed = true};
  std::vector<std::uint64_t> bits{d.first.mask};
  if (!words.empty()) bits.resize(words.size() / sizeof(std::uint64_t));
  for (std::size_t i = 0; i < words.size() / sizeof(std::uint64_t); ++i)
    bits[i] = load_word(&words[i * sizeof(std::uint64_t)]);
  FieldMask mask = FieldMask::from_words(type_->leaves(), bits);
  if (mask.hash() != d.first.mask || type_->closed(mask) != mask) return {.malformed = true};
  if (std::ranges::none_of(wanted_, [&](const Wanted& w) { return mask.contains(w.mask); })) return {};
  if (merged_.size() == merged_max) merged_.erase(merged_.begin());
  return {.mask = &merged_.emplace_back(std::move(mask))};
}

}  // namespace sft::udp
