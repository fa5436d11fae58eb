// Samples of SFT as Cyclone DDS sends and receives them: their CDR bytes without changes, and without any
// description of the type. Samples are sent without a copy. A received sample is copied once, from the
// datagrams. The threads of Cyclone check it, once for all readers that read in the same way, and swap
// big-endian numbers. The code uses the internal types with which Cyclone's own serializers are written.
// These types did not change between Cyclone's releases 0.10.2 and 0.10.5.
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

/// A topic for such samples in a participant. If `entity` is negative, it is an error of Cyclone. The type
/// lives as long as the topic.
struct RawTopic {
  dds_entity_t entity = 0;
  const ddsi_sertype* type = nullptr;
};
/// The type of received samples, and the memory for them.
struct RawReading {
  const TypeSupport* type = nullptr;         ///< null: bodies are neither checked nor indexed
  std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null if the type is static
  /// The memory for received samples, of which a quarter is left for other uses; null: samples are only
  /// sent
  std::shared_ptr<BufferPool> memory{};
};
RawTopic raw_topic(dds_entity_t participant, const std::string& name, const std::string& type_name,
                   RawReading reading = {});

/// Returns one reference to a sample of this type, for dds_forwardcdr(), with the source timestamp of
/// `sample`. The handle is kept until Cyclone does not need the bytes any more, and is then released by a
/// thread of Cyclone. `sample` must have all fields, and `slots` must be the number of slots of its
/// TypeSupport.
ddsi_serdata* raw_sample(const ddsi_sertype* type, const SampleHandle& sample, std::size_t slots);
/// Returns a sample without an index whose body is a copy of these bytes. The handle is empty if there is
/// no memory.
SampleHandle raw_body(std::span<const std::byte> body, const RawReading& reading);

/// The reason why a received sample cannot be read.
enum class RawFault : std::uint8_t {
  none,
  malformed,
  other_encoding,  ///< the encoding is not XCDR1, according to the encapsulation
  no_memory,
};

/// A received sample. It has all fields, and an index if its type is known. Several readers share it, so it
/// must not be changed.
struct RawArrival {
  SampleHandle sample{};       ///< empty if there is a fault
  std::uint64_t sequence = 0;  ///< the number that the DDS writer has given to the sample, from 1; 0: unknown
  RawFault fault = RawFault::none;
};
/// Returns the received sample in `data`, which must be a sample of a topic that was made with a
/// RawReading.
RawArrival raw_arrival(const ddsi_serdata* data);

}  // namespace sft::core
