// Samples of SFT as Cyclone DDS sends and receives them: their CDR bytes as they are, without any description
// of the type. They are sent without a copy. What is received is copied once, out of the datagrams, and is
// checked by the threads of Cyclone, once for all readers that read the same way; big-endian numbers are
// swapped. These types are those that Cyclone's own serializers are made of; they did not change between its
// releases 0.10.2 and 0.10.5.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/seam/buffer_pool.h"
#include "core/seam/sample_buffer.h"
#include "sft/type_support.h"

namespace sft::core {

/// A topic of such samples in a participant, or an error of Cyclone in `entity`. The type lives as long as
/// the topic.
struct RawTopic {
  dds_entity_t entity = 0;
  const ddsi_sertype* type = nullptr;
};
/// The type and the memory for samples that are received.
struct RawReading {
  const TypeSupport* type = nullptr;         ///< null: bodies are neither checked nor indexed
  std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null if it is static
  std::shared_ptr<BufferPool> memory{};      ///< a quarter of its limit is left for other uses; null: samples
                                             ///< are only sent
};
RawTopic raw_topic(dds_entity_t participant, const std::string& name, const std::string& type_name,
                   RawReading reading = {});

/// One reference to a sample of this type, for dds_forwardcdr(); its source timestamp is that of the sample.
/// The handle is kept until Cyclone needs the bytes no more, and is dropped in a thread of Cyclone. `sample`
/// has all fields, and `slots` is that of its TypeSupport.
ddsi_serdata* raw_sample(const ddsi_sertype* type, const SampleHandle& sample, std::size_t slots);
/// Returns a sample without an index whose body is a copy of these bytes. It is empty if there is no memory.
SampleHandle raw_body(std::span<const std::byte> body, const RawReading& reading);

/// The reason why a received sample cannot be read.
enum class RawFault : std::uint8_t {
  none,
  malformed,
  other_encoding,  ///< not XCDR1: its bytes say so
  no_memory,
};

/// A sample that was received. It has all fields, and an index if its type is known. Several readers share
/// it, so it must not be changed.
struct RawArrival {
  SampleHandle sample{};       ///< empty if there is a fault
  std::uint64_t sequence = 0;  ///< the number that its DDS writer gave it, from 1; 0: unknown
  RawFault fault = RawFault::none;
};
/// `data` is a sample of a topic that was made with a RawReading.
RawArrival raw_arrival(const ddsi_serdata* data);

}  // namespace sft::core
