// A handle that owns policies of Cyclone DDS.
#pragma once

#include <dds/dds.h>

#include <memory>

namespace sft::core {

struct DdsQosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using DdsQos = std::unique_ptr<dds_qos_t, DdsQosDeleter>;

}  // namespace sft::core
