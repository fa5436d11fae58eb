// Samples of SFT as Cyclone DDS sends them: their CDR bytes as they are, without a copy and without any
// description of the type. These types are those that Cyclone's own serializers are made of; they did not
// change between its releases 0.10.2 and 0.10.5.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <cstddef>
#include <string>

#include "core/seam/sample_buffer.h"

namespace sft::core {

/// A topic of such samples in a participant, or an error of Cyclone in `entity`. The type lives as long as
/// the topic.
struct RawTopic {
  dds_entity_t entity = 0;
  const ddsi_sertype* type = nullptr;
};
RawTopic raw_topic(dds_entity_t participant, const std::string& name, const std::string& type_name);

/// One reference to a sample of this type, for dds_forwardcdr(); its source timestamp is that of the sample.
/// The handle is kept until Cyclone needs the bytes no more, and is dropped in a thread of Cyclone. `sample`
/// has all fields, and `slots` is that of its TypeSupport.
ddsi_serdata* raw_sample(const ddsi_sertype* type, const SampleHandle& sample, std::size_t slots);

}  // namespace sft::core
