#include "udp_transport/multicast/body_sizes.h"

#include <algorithm>

namespace sft::udp {

void BodySizes::follow(const TypeSupport& type, std::span<const Selection> selections) {
  Parts next;
  for (const Selection& selection : selections) {
    const auto is_it = [&](const auto& size) { return size->selection() == selection; };
    if (selection.parts().empty() || std::ranges::any_of(next, is_it)) continue;
    const auto known = std::ranges::find_if(followed_, is_it);
    next.push_back(known != followed_.end() ? *known : std::make_shared<PartSize>(type, selection));
  }
  if (next == followed_) return;
  followed_ = next;
  parts_.replace(std::make_shared<const Parts>(std::move(next)));
}

std::shared_ptr<const PartSize> BodySizes::part_size(const Selection& selection) const {
  if (selection.parts().empty()) return {};
  const auto found =
      std::ranges::find_if(followed_, [&](const auto& size) { return size->selection() == selection; });
  return found == followed_.end() ? nullptr : *found;
}

bool BodySizes::known(const Selection& selection) const {
  if (!leaves_.known(selection.mask())) return false;
  if (selection.parts().empty()) return true;
  const auto part = part_size(selection);
  return part != nullptr && part->known();
}

bool BodySizes::known_all(std::span<const Selection> selections) const {
  return std::ranges::all_of(selections, [this](const Selection& one) { return known(one); });
}

double BodySizes::bytes_of(const Selection& selection) const {
  const double whole = leaves_.bytes(selection.mask());
  const auto part = part_size(selection);
  return part == nullptr ? whole : std::max(0.0, whole - part->bytes_less());
}

}  // namespace sft::udp
