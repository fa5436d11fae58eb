#include "core/vanilla/vanilla_matching.h"

#include <algorithm>

#include "core/control/qos.h"
#include "core/discovery/participant_data.h"
#include "core/platform/quotes.h"

namespace sft::core {

namespace {

void add(std::string& reasons, const std::string& reason) {
  if (!reason.empty()) reasons += (reasons.empty() ? "" : "; ") + reason;
}

/// A pattern of partitions can match the default one only if it is made of stars.
bool is_default_partition(const std::string& name) {
  return std::ranges::all_of(name, [](char letter) { return letter == '*'; });
}

}  // namespace

std::string endpoint_user_data(std::string_view type_hash) {
  std::string text;
  if (!type_hash.empty()) text = "typehash=" + std::string(type_hash) + ";";
  return text + std::string(vanilla_mark);
}

Qos offered_to_vanilla(const Qos& publisher) {
  Qos offered = publisher;
  offered.reliability = Reliability::reliable;
  offered.liveliness = Liveliness::automatic;
  offered.liveliness_lease = {};
  return offered;
}

std::string why_not_served(std::string_view type_name, const Qos& offered, const VanillaReader& reader) {
  std::string reasons;
  if (reader.type_name != type_name) {
    add(reasons, "its type is " + in_quotes(reader.type_name) + ", and that of the publisher is " +
                     in_quotes(std::string(type_name)));
  }
  if (reader.is_keyed) add(reasons, "its type has keys, and that of the publisher has none");
  if (!reader.takes_xcdr1) {
    add(reasons,
        "it takes XCDR2 only (a type that is @appendable or @mutable), and samples are XCDR1: make "
        "its type @final");
  }
  add(reasons, conflict_between(offered, reader.qos).reason);
  if (!reader.partitions.empty() && std::ranges::none_of(reader.partitions, is_default_partition)) {
    add(reasons, "it is in the partition " + in_quotes(reader.partitions.front()) +
                     ", and the publisher is in the default one");
  }
  if (reader.owns_exclusively) add(reasons, "it asks for exclusive ownership, and the publisher shares");
  return reasons;
}

}  // namespace sft::core
