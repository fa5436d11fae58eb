#include "core/vanilla/vanilla_readers.h"

#include <algorithm>
#include <chrono>
#include <iterator>

#include "core/discovery/participant_data.h"

namespace sft::core {

namespace {

// The last octet of the key of a reader whose type has keys (RTPS 2.3, 9.3.1.2).
constexpr unsigned char keyed_reader = 0x07;

std::string user_data_in(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t bytes = 0;
  if (!dds_qget_userdata(qos, &data, &bytes) || data == nullptr) return {};
  std::string user_data(static_cast<const char*>(data), bytes);
  dds_free(data);
  return user_data;
}

std::chrono::nanoseconds duration_of(dds_duration_t duration) {
  return std::chrono::nanoseconds(duration == DDS_INFINITY ? 0 : duration);
}

Qos requested_in(const dds_qos_t* qos) {
  Qos requested;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  dds_liveliness_kind_t liveliness = DDS_LIVELINESS_AUTOMATIC;
  dds_duration_t deadline = DDS_INFINITY, lease = DDS_INFINITY;
  dds_qget_reliability(qos, &reliability, nullptr);
  dds_qget_durability(qos, &durability);
  dds_qget_deadline(qos, &deadline);
  dds_qget_liveliness(qos, &liveliness, &lease);
  if (reliability == DDS_RELIABILITY_RELIABLE) requested.reliability = Reliability::reliable;
  if (durability != DDS_DURABILITY_VOLATILE) requested.durability = Durability::transient_local;
  if (liveliness != DDS_LIVELINESS_AUTOMATIC) requested.liveliness = Liveliness::manual_by_topic;
  requested.deadline = duration_of(deadline);
  requested.liveliness_lease = duration_of(lease);
  return requested;
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

/// A reader that names no representation takes XCDR1.
bool takes_xcdr1(const dds_qos_t* qos) {
  std::uint32_t count = 0;
  dds_data_representation_id_t* values = nullptr;
  if (!dds_qget_data_representation(qos, &count, &values) || count == 0) return true;
  const bool takes = std::find(values, values + count, DDS_DATA_REPRESENTATION_XCDR1) != values + count;
  dds_free(values);
  return takes;
}

VanillaReader described(const dds_builtintopic_endpoint_t& reader) {
  dds_ownership_kind_t ownership = DDS_OWNERSHIP_SHARED;
  dds_qget_ownership(reader.qos, &ownership);
  return {.type_name = reader.type_name,
          .qos = requested_in(reader.qos),
          .partitions = partitions_in(reader.qos),
          .takes_xcdr1 = takes_xcdr1(reader.qos),
          .is_keyed = reader.key.v[sizeof reader.key.v - 1] == keyed_reader,
          .owns_exclusively = ownership == DDS_OWNERSHIP_EXCLUSIVE};
}

}  // namespace

VanillaReaders::VanillaReaders(dds_entity_t participant) {
  dds_listener_t* const listener = dds_create_listener(this);
  dds_lset_data_available(
      listener, [](dds_entity_t builtin, void* self) { static_cast<VanillaReaders*>(self)->take(builtin); });
  dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, nullptr, listener);
  dds_delete_listener(listener);
}

void VanillaReaders::take(dds_entity_t builtin) {
  const Lock lock(mutex_);
  void* sample = nullptr;
  dds_sample_info_t info{};
  while (dds_take(builtin, &sample, &info, 1, 1) > 0) {
    note(*static_cast<const dds_builtintopic_endpoint_t*>(sample), info);
    dds_return_loan(builtin, &sample, 1);
    sample = nullptr;
  }
}

void VanillaReaders::note(const dds_builtintopic_endpoint_t& reader, const dds_sample_info_t& info) {
  Key key{};
  std::copy(std::begin(reader.key.v), std::end(reader.key.v), key.begin());
  if (info.instance_state != DDS_IST_ALIVE) {
    known_.erase(key);
  } else if (info.valid_data && known_.size() < known_max && !is_of_sft(user_data_in(reader.qos))) {
    known_.insert_or_assign(key, std::pair(std::string(reader.topic_name), described(reader)));
    changes_.fetch_add(1, std::memory_order_relaxed);
  }
}

std::vector<VanillaReader> VanillaReaders::of(std::string_view topic) const {
  std::vector<VanillaReader> readers;
  const Lock lock(mutex_);
  for (const auto& [key, reader] : known_) {
    if (reader.first == topic) readers.push_back(reader.second);
  }
  return readers;
}

}  // namespace sft::core
