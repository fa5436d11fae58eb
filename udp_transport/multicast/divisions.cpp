#include "udp_transport/multicast/divisions.h"

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>

namespace sft::udp {

namespace {

struct Known {
  DividedPlace of;
  std::size_t number = 0;
  std::size_t places = 0;
  bool has_group = false;
  double bytes_per_s = 0;
  std::string_view refusal{};
};

bool are_alike(const DividedPlace& a, const DividedPlace& b) {
  if (a.link != b.link || (a.some_samples == nullptr) != (b.some_samples == nullptr)) return false;
  return a.some_samples == nullptr || *a.some_samples == *b.some_samples;
}

void refuse_some(std::vector<Known>& divisions) {
  std::ranges::stable_sort(divisions, std::greater(), [](const Known& one) {
    return std::tuple(one.has_group, one.bytes_per_s, one.places);
  });
  std::map<std::size_t, std::size_t> groups_behind;  // number of groups of such divisions, by link
  for (Known& one : divisions) {
    if (one.of.some_samples == nullptr) continue;
    if (one.places < 2) {
      one.refusal =
          "no other host that could be in a group asks for the same at its rate or under its conditions";
    } else if (++groups_behind[one.of.link] > some_samples_groups_max) {
      one.refusal =
          "other conditions or maximum rates have all the groups that there may be, or are sent more";
    }
  }
}

}  // namespace

std::vector<Division> divide(std::span<const DividedPlace> places) {
  std::vector<Known> divisions;
  std::vector<Division> all;
  for (const DividedPlace& place : places) {
    auto known = std::ranges::find_if(divisions, [&](const Known& one) { return are_alike(one.of, place); });
    if (known == divisions.end()) known = divisions.insert(known, {place, divisions.size()});
    ++known->places;
    known->has_group = known->has_group || place.is_in_group;
    known->bytes_per_s += place.bytes_per_s;
    all.push_back({known->number});
  }
  refuse_some(divisions);
  for (Division& one : all) one.refusal = std::ranges::find(divisions, one.number, &Known::number)->refusal;
  return all;
}

}  // namespace sft::udp
