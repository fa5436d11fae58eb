#include "core/vanilla/vanilla_endpoints.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <iterator>

#include "core/discovery/participant_data.h"
#include "sft/detail/fnv1a.h"

namespace sft::core {

namespace {

// The last byte of the GUIDs of writers and readers whose types have keys (RTPS 2.3, 9.3.1.2).
constexpr unsigned char keyed_writer = 0x02, keyed_reader = 0x07;

std::chrono::nanoseconds duration_of(dds_duration_t duration) {
  return std::chrono::nanoseconds(duration == DDS_INFINITY ? 0 : duration);
}

Qos policies_in(const dds_qos_t* qos) {
  Qos policies;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_liveliness_kind_t liveliness = DDS_LIVELINESS_AUTOMATIC;
  dds_duration_t deadline = DDS_INFINITY, lease = DDS_INFINITY, lifespan = DDS_INFINITY;
  dds_qget_reliability(qos, &reliability, nullptr);
  dds_qget_durability(qos, &durability);
  dds_qget_deadline(qos, &deadline);
  dds_qget_liveliness(qos, &liveliness, &lease);
  dds_qget_lifespan(qos, &lifespan);
  if (reliability == DDS_RELIABILITY_RELIABLE) policies.reliability = Reliability::reliable;
  if (durability != DDS_DURABILITY_VOLATILE) policies.durability = Durability::transient_local;
  if (liveliness != DDS_LIVELINESS_AUTOMATIC) policies.liveliness = Liveliness::manual_by_topic;
  policies.deadline = duration_of(deadline);
  policies.liveliness_lease = duration_of(lease);
  policies.lifespan = duration_of(lifespan);
  return policies;
}

std::vector<std::string> partitions_in(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  char** names = nullptr;
  if (!dds_qget_partition(qos, &count, &names)) return {};
  std::vector<std::string> partitions(names, names + count);
  std::for_each(names, names + count, [](char* name) { dds_free(name); });
  dds_free(names);
  return partitions;
}

/// Returns true if the endpoint uses XCDR1. An endpoint that names no representation uses XCDR1. A writer
/// uses the first representation that it names.
bool has_xcdr1(const dds_qos_t* qos, bool is_writer) {
  std::uint32_t count = 0;
  dds_data_representation_id_t* values = nullptr;
  if (!dds_qget_data_representation(qos, &count, &values) || count == 0) return true;
  const auto* const end = values + (is_writer ? 1 : count);
  const bool has =
      std::find<const dds_data_representation_id_t*>(values, end, DDS_DATA_REPRESENTATION_XCDR1) != end;
  dds_free(values);
  return has;
}

/// Returns the hash that an endpoint announces. The result is empty if the hash is not a single word,
/// because it is shown to users.
std::string type_hash_of(const dds_qos_t* qos) {
  const std::string user_data = user_data_in(qos);
  const std::string_view hash = type_hash_in(user_data);
  const auto is_of_word = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  return std::ranges::all_of(hash, is_of_word) ? std::string(hash) : std::string();
}

/// Returns true for endpoints of the control topics of SFT, and for those by which Cyclone tells this process
/// what it has discovered. They have no samples of programs.
bool is_internal(const dds_builtintopic_endpoint_t& endpoint) {
  const std::string_view type = endpoint.type_name;
  return type.starts_with("sft_control::") || type.starts_with("org::eclipse::cyclonedds::builtin::");
}

std::string in_hexadecimal(const dds_guid_t& guid, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) {
    text += "0123456789abcdef"[guid.v[i] >> 4];
    text += "0123456789abcdef"[guid.v[i] & 15];
  }
  return text;
}

}  // namespace

Guid guid_of(const dds_guid_t& guid) {
  Guid copy{};
  std::copy(std::begin(guid.v), std::end(guid.v), copy.begin());
  return copy;
}

Guid guid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  return guid_of(guid);
}

std::string name_of_participant(const dds_guid_t& participant) {
  constexpr std::size_t prefix_bytes = 12;
  return "DDS " + in_hexadecimal(participant, prefix_bytes);
}

VanillaEndpoint described(const dds_builtintopic_endpoint_t& endpoint) {
  dds_ownership_kind_t ownership = DDS_OWNERSHIP_SHARED;
  dds_qget_ownership(endpoint.qos, &ownership);
  const unsigned char kind = endpoint.key.v[sizeof endpoint.key.v - 1];
  detail::Fnv1a id;
  id.add(std::string_view(reinterpret_cast<const char*>(endpoint.key.v), sizeof endpoint.key.v));
  return {.id = id.value(),
          .guid = in_hexadecimal(endpoint.key, sizeof endpoint.key.v),
          .participant = name_of_participant(endpoint.participant_key),
          .type_name = endpoint.type_name,
          .type_hash = type_hash_of(endpoint.qos),
          .qos = policies_in(endpoint.qos),
          .partitions = partitions_in(endpoint.qos),
          .has_xcdr1 = has_xcdr1(endpoint.qos, kind <= 3),
          .is_keyed = kind == keyed_reader || kind == keyed_writer,
          .owns_exclusively = ownership == DDS_OWNERSHIP_EXCLUSIVE,
          .key = guid_of(endpoint.key)};
}

bool is_endpoint_of_sft(const dds_qos_t* qos) { return qos != nullptr && is_of_sft(user_data_in(qos)); }

/// Also takes the endpoints that were discovered before.
VanillaEndpoints::VanillaEndpoints(dds_entity_t participant, dds_entity_t builtin_topic,
                                   std::function<void()> changed, std::size_t at_most)
    : participant_(participant),
      builtin_topic_(builtin_topic),
      changed_(std::move(changed)),
      at_most_(at_most) {
  reader_ = open_reader();
  if (reader_ > 0) take(reader_);
}

dds_entity_t VanillaEndpoints::open_reader() {
  dds_listener_t* const listener = dds_create_listener(this);
  dds_lset_data_available(listener, [](dds_entity_t builtin, void* self) {
    static_cast<VanillaEndpoints*>(self)->take(builtin);
  });
  const dds_entity_t reader = dds_create_reader(participant_, builtin_topic_, nullptr, listener);
  dds_delete_listener(listener);
  return reader;
}

VanillaEndpoints::~VanillaEndpoints() {
  if (reader_ > 0) dds_delete(reader_);
}

/// Opens a new reader, which gets all present endpoints. The former reader is deleted afterwards, so that
/// no departure is missed meanwhile.
void VanillaEndpoints::look_again(Time now) {
  {
    const Lock lock(mutex_);
    if (!has_ignored_ || known_.size() >= at_most_ || now < next_look_) return;
    has_ignored_ = false;
    next_look_ = Time::max();
  }
  const dds_entity_t reader = open_reader();
  if (reader > 0) {
    take(reader);
    dds_delete(std::exchange(reader_, reader));
  }
  const Lock lock(mutex_);
  has_ignored_ = has_ignored_ || reader <= 0;
  next_look_ = now + looks_apart;
}

void VanillaEndpoints::take(dds_entity_t builtin) {
  bool is_news = false;
  {
    const Lock lock(mutex_);
    void* sample = nullptr;
    dds_sample_info_t info{};
    while (dds_take(builtin, &sample, &info, 1, 1) > 0) {
      is_news |= note(*static_cast<const dds_builtintopic_endpoint_t*>(sample), info);
      dds_return_loan(builtin, &sample, 1);
      sample = nullptr;
    }
  }
  if (is_news && changed_) changed_();
}

/// Returns true if the known endpoints have changed.
bool VanillaEndpoints::note(const dds_builtintopic_endpoint_t& endpoint, const dds_sample_info_t& info) {
  Key key{};
  std::copy(std::begin(endpoint.key.v), std::end(endpoint.key.v), key.begin());
  if (info.instance_state != DDS_IST_ALIVE) {
    of_sft_.erase(key);
    if (known_.erase(key) == 0) return false;
  } else {
    if (!info.valid_data || is_internal(endpoint)) return false;
    if (const std::string user_data = user_data_in(endpoint.qos); is_of_sft(user_data)) {
      if (of_sft_.size() < known_max || of_sft_.contains(key))
        of_sft_.insert_or_assign(key, OfSft{id_in(user_data), is_answered_in(user_data)});
      return false;
    }
    if (known_.size() >= at_most_ && !known_.contains(key)) {
      has_ignored_ = true;
      return false;
    }
    known_.insert_or_assign(key, OfTopic{endpoint.topic_name, described(endpoint)});
  }
  changes_.fetch_add(1, std::memory_order_relaxed);
  return true;
}

std::vector<VanillaEndpoint> VanillaEndpoints::of(std::string_view topic) const {
  std::vector<VanillaEndpoint> endpoints;
  const Lock lock(mutex_);
  for (const auto& [key, endpoint] : known_) {
    if (endpoint.topic == topic) endpoints.push_back(endpoint.endpoint);
  }
  return endpoints;
}

std::vector<VanillaEndpoints::OfTopic> VanillaEndpoints::all() const {
  std::vector<OfTopic> endpoints;
  const Lock lock(mutex_);
  for (const auto& [key, endpoint] : known_) endpoints.push_back(endpoint);
  return endpoints;
}

std::set<EndpointId> VanillaEndpoints::of_sft() const {
  std::set<EndpointId> ids;
  const Lock lock(mutex_);
  for (const auto& [key, endpoint] : of_sft_) ids.insert(endpoint.id);
  return ids;
}

std::set<EndpointId> VanillaEndpoints::unanswered() const {
  std::set<EndpointId> ids;
  const Lock lock(mutex_);
  for (const auto& [key, endpoint] : of_sft_)
    if (!endpoint.is_answered) ids.insert(endpoint.id);
  return ids;
}

}  // namespace sft::core
