// The fields that a subscriber requests and, if they are recorded, the fields that its program has read:
//
//   const sft::Requirements seen = recorded.requirements();                   // after it ran for a while
//   auto declared = node.subscriber("points", type, seen.text);               // always requests these
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sft/mask.h"

namespace sft {

/// The result of Subscriber::requirements(): a copy, made at the time of the call, that any thread may use.
/// A read on any thread counts, but only once its sample has been released. Reads by getters count; copies
/// of the whole sample (cdr(), to_partial()) do not.
struct Requirements {
  /// One leaf of the message type (type.h). Samples are numbered from 1, in the order in which the program
  /// released them.
  struct Field {
    std::string path;               ///< "fields[].name"
    std::uint64_t samples = 0;      ///< the number of samples in which the field was read
    std::uint64_t last_sample = 0;  ///< the number of the last of these samples; 0: the field was never read
    bool requested = false;         ///< true: the subscriber requests the field at present
  };

  bool recorded = false;      ///< false: the fields are declared, and nothing is counted
  std::uint64_t samples = 0;  ///< the number of samples that were released
  FieldMask mask;             ///< the fields that were read in at least one sample, or that are declared
  /// If fields are declared, the declared selection, otherwise the fields and channels that were read; as
  /// text for Node::subscriber().
  std::string text;
  std::vector<Field> fields;  ///< all leaves of the type
};

}  // namespace sft
