// The single operations of the data path that this benchmark times.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "bench/common/contest.h"

namespace sft::bench::micro {

struct Operation {
  std::string name;
  std::size_t copied_bytes;  ///< by the memcpy that it is measured against
  Batch batch;               ///< owns all that the operation needs
};

using Operations = std::vector<Operation>;

/// What operations that touch only a few bytes are measured against.
inline constexpr std::size_t small_copy_bytes = 1024;

/// From a message in the program's memory to its CDR and index.
Operations encode_operations();
/// From an encoded sample to the runs of its body that a mask asks for.
Operations gather_operations();
/// Getters of an encoded sample.
Operations view_operations();
/// Sets of fields: reading their text, joining and comparing them.
Operations mask_operations();
/// From an encoded body to datagrams.
Operations fragment_operations();
/// From datagrams to a sample that was checked and has its index.
Operations reassemble_operations();
/// A reader asks for other fields, until the publisher knows what to send to whom.
Operations negotiate_operations();

}  // namespace sft::bench::micro
