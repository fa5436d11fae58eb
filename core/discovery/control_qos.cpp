#include "core/discovery/control_qos.h"

#include <algorithm>
#include <cstddef>

namespace sft::core {

DdsQos control_qos() {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
  dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 1);
  // A killed node's endpoints must end as "no writers", not as "disposed": only withdrawing disposes of them.
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

DdsQos assertion_qos(std::chrono::milliseconds lease) {
  DdsQos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, 16);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_MANUAL_BY_TOPIC, DDS_MSECS(lease.count()));
  dds_qset_writer_data_lifecycle(qos.get(), false);
  return qos;
}

DdsQos copy_of(const dds_qos_t* qos) {
  DdsQos copy(dds_create_qos());
  dds_copy_qos(copy.get(), qos);
  return copy;
}

DdsQos hearing_qos(const dds_qos_t* written) {
  DdsQos qos = copy_of(written);
  dds_qset_liveliness(qos.get(), DDS_LIVELINESS_AUTOMATIC, DDS_INFINITY);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

DdsQos participant_qos(const ParticipantMark& mark) {
  const std::string data = to_text(mark);
  DdsQos qos(dds_create_qos());
  dds_qset_userdata(qos.get(), data.data(), data.size());
  return qos;
}

std::string user_data_of(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t bytes = 0;
  if (!dds_qget_userdata(qos, &data, &bytes) || data == nullptr) return {};
  std::string user_data(static_cast<const char*>(data), bytes);
  dds_free(data);
  return user_data;
}

std::chrono::milliseconds liveliness_lease(const dds_qos_t* qos) {
  dds_liveliness_kind_t kind{};
  dds_duration_t lease = DDS_INFINITY;
  dds_qget_liveliness(qos, &kind, &lease);
  const auto milliseconds =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::nanoseconds(lease));
  return std::min<std::chrono::milliseconds>(milliseconds, longest_lease);
}

}  // namespace sft::core
