// The single operations of the data path that this benchmark times.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bench/common/contest.h"

namespace sft::bench::micro {

struct Operation {
  std::string name;
  std::size_t copied_bytes;  ///< the bytes of the memcpy with which it is compared
  Batch batch;               ///< owns everything that the operation needs
};

using Operations = std::vector<Operation>;

/// The bytes of the memcpy for operations that touch only a few bytes.
inline constexpr std::size_t small_copy_bytes = 1024;

/// Encodes a message in the program's memory as CDR and index.
Operations encode_operations();
/// Gathers the runs of an encoded sample's body for which a mask asks.
Operations gather_operations();
/// Reads an encoded sample by getters.
Operations view_operations();
/// Reads sets of fields from text, joins and compares them.
Operations mask_operations();
/// Cuts an encoded body into datagrams.
Operations fragment_operations();
/// Reassembles datagrams to a sample that is checked and has its index.
Operations reassemble_operations();
/// Changes a reader's request, until the publisher knows which fields to send to which readers.
Operations negotiate_operations();

}  // namespace sft::bench::micro
