// The single operations of the data path that this benchmark times.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bench/common/contest.h"

namespace sft::bench::micro {

struct Operation {
  std::string name;
  std::size_t copied_bytes;  ///< the bytes of the memcpy with which the operation is compared
  Batch batch;               ///< owns everything that the operation needs
};

using Operations = std::vector<Operation>;

/// The bytes of the memcpy that is compared with operations that touch only a few bytes.
inline constexpr std::size_t small_copy_bytes = 1024;

/// Returns operations that encode a message in the program's memory as CDR and index.
Operations encode_operations();
/// Returns operations that gather the runs of an encoded sample's body for a mask.
Operations gather_operations();
/// Returns operations that read an encoded sample by getters.
Operations view_operations();
/// Returns operations that read sets of fields from text, join and compare them.
Operations mask_operations();
/// Returns operations that cut an encoded body into datagrams.
Operations fragment_operations();
/// Returns operations that reassemble datagrams to a sample. The sample is checked and gets its index.
Operations reassemble_operations();
/// Returns operations that change a reader's request, until the publisher knows which fields to send to
/// which readers.
Operations negotiate_operations();

}  // namespace sft::bench::micro
