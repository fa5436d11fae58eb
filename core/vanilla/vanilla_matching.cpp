#include "core/vanilla/vanilla_matching.h"

#include <algorithm>
#include <charconv>

#include "core/discovery/participant_data.h"
#include "core/names/qos.h"
#include "core/platform/quotes.h"

namespace sft::core {

namespace {

constexpr std::string_view type_hash_key = "typehash=";
constexpr std::string_view id_key = "sft_id=";
constexpr std::string_view unanswered_key = "sft_unanswered=";

/// Returns the value of this key in user data, which consist of pairs "key=value;". `key` ends with "=".
std::string_view value_in(std::string_view user_data, std::string_view key) {
  for (std::size_t at = 0; at < user_data.size();) {
    const std::string_view pair = user_data.substr(at, user_data.find(';', at) - at);
    if (pair.starts_with(key)) return pair.substr(key.size());
    at += pair.size() + 1;
  }
  return {};
}

void add(std::string& reasons, const std::string& reason) {
  if (!reason.empty()) reasons += (reasons.empty() ? "" : "; ") + reason;
}

/// Returns true if the pattern matches the default partition, which is so only if it consists of asterisks.
bool is_default_partition(const std::string& name) {
  return std::ranges::all_of(name, [](char letter) { return letter == '*'; });
}

/// `ours` is "publisher" or "subscriber".
void add_of_type(std::string& reasons, std::string_view type_name, const std::string& ours,
                 const VanillaEndpoint& theirs) {
  if (theirs.type_name != type_name) {
    add(reasons, "its type is " + in_quotes(theirs.type_name) + ", and that of the " + ours + " is " +
                     in_quotes(std::string(type_name)));
  }
  if (theirs.is_keyed) add(reasons, "its type has keys, and that of the " + ours + " has none");
}

void add_of_place(std::string& reasons, const std::string& ours, const VanillaEndpoint& theirs) {
  if (!theirs.partitions.empty() && std::ranges::none_of(theirs.partitions, is_default_partition)) {
    add(reasons, "it is in the partition " + in_quotes(theirs.partitions.front()) + ", and the " + ours +
                     " is in the default one");
  }
  if (theirs.owns_exclusively) add(reasons, "it asks for exclusive ownership, and the " + ours + " shares");
}

}  // namespace

std::string endpoint_user_data(std::string_view type_hash, EndpointId id, bool is_answered) {
  std::string text;
  if (!type_hash.empty()) text = std::string(type_hash_key) + std::string(type_hash) + ";";
  text += std::string(vanilla_mark) + std::string(id_key) + std::to_string(id) + ";";
  return is_answered ? text : text + std::string(unanswered_key) + "1;";
}

std::string_view type_hash_in(std::string_view user_data) { return value_in(user_data, type_hash_key); }

EndpointId id_in(std::string_view user_data) {
  const std::string_view text = value_in(user_data, id_key);
  EndpointId id = 0;
  std::from_chars(text.data(), text.data() + text.size(), id);
  return id;
}

bool is_answered_in(std::string_view user_data) { return value_in(user_data, unanswered_key).empty(); }

Qos offered_to_vanilla(const Qos& publisher) {
  Qos offered = publisher;
  offered.reliability = Reliability::reliable;
  offered.liveliness = Liveliness::automatic;
  offered.liveliness_lease = {};
  return offered;
}

Qos requested_from_vanilla(const Qos& subscriber) {
  Qos requested = subscriber;
  if (requested.durability == Durability::transient_local) requested.reliability = Reliability::reliable;
  return requested;
}

std::string difference_of_hashes(std::string_view type_hash, const std::string& ours,
                                 const VanillaEndpoint& theirs) {
  if (type_hash.empty() || theirs.type_hash.empty() || theirs.type_hash == type_hash) return {};
  return "its type has another definition (" + theirs.type_hash + ") than that of the " + ours + " (" +
         std::string(type_hash) + ")";
}

std::string why_not_served(std::string_view type_name, const Qos& offered, const VanillaEndpoint& reader) {
  std::string reasons;
  add_of_type(reasons, type_name, "publisher", reader);
  if (!reader.has_xcdr1) {
    add(reasons,
        "it takes XCDR2 only (a type that is @appendable or @mutable), and samples are XCDR1: make "
        "its type @final");
  }
  add(reasons, conflict_between(offered, reader.qos).reason);
  add_of_place(reasons, "publisher", reader);
  return reasons;
}

std::string why_not_heard(std::string_view type_name, std::string_view type_hash, const Qos& requested,
                          const VanillaEndpoint& writer) {
  std::string reasons;
  add_of_type(reasons, type_name, "subscriber", writer);
  add(reasons, difference_of_hashes(type_hash, "subscriber", writer));
  if (!writer.has_xcdr1) {
    add(reasons,
        "it sends XCDR2 (a type that is @appendable or @mutable), and subscribers read XCDR1: make "
        "its type @final");
  }
  add(reasons, conflict_between(writer.qos, requested).reason);
  add_of_place(reasons, "subscriber", writer);
  return reasons;
}

}  // namespace sft::core
