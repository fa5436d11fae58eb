// What a subscriber asks for and, where its fields are recorded, what its code was seen to read:
//
//   const sft::Requirements seen = recorded.requirements();                   // after it ran for a while
//   auto declared = node.subscriber("points", type, seen.text);               // asks for just that, for good
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sft/typesupport/field_mask.h"

namespace sft {

/// A leaf of the message type. Samples are numbered from 1 in the order in which they were released.
struct FieldRequirement {
  std::string path;               ///< "fields[].name"
  std::uint64_t samples = 0;      ///< in so many it was read
  std::uint64_t last_sample = 0;  ///< the number of the last of them; 0: it never was
  bool requested = false;         ///< it is asked for at present
};

/// A snapshot. Reads count once their sample has been released, on whatever thread they were; those by
/// getters do, copies of the whole sample (cdr(), to_partial()) do not.
struct Requirements {
  bool recorded = false;      ///< false: declared, and nothing is counted
  std::uint64_t samples = 0;  ///< that were released
  FieldMask mask;             ///< what was read in at least one of them; or what is declared
  std::string text;           ///< the same, as Node::subscriber and TypeSupport::parse_mask take it
  std::vector<FieldRequirement> fields;  ///< all of the type
};

}  // namespace sft
