// The masks, parts of fields and conditions that readers of this process ask a writer for, and which of
// them a datagram names.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "sft/selection.h"
#include "udp_transport/wire/datagram.h"

namespace sft {
class TypeSupport;
}

namespace sft::udp {

class WantedMasks {
 public:
  /// Sets what is wanted from now on. `type` outlives this object.
  void set(const TypeSupport& type, std::span<const Selection> selections);

  struct Named {
    const FieldMask* mask = nullptr;  ///< null: no reader wants such samples; valid until the next call
    std::uint64_t parts = 0;          ///< value of SampleBuffer::parts
    std::uint64_t conditions = 0;     ///< the hash of the conditions under which the sample is sent; 0: none
    bool malformed = false;
  };
  /// Returns what a first, whole or packed datagram names. Takes the mask's words from its payload.
  Named named_by(Datagram& d);

 private:
  struct Wanted {
    FieldMask mask;
    std::uint64_t hash;
    std::uint64_t parts;
    std::uint64_t conditions;
  };
  Named merged(const Datagram& d, std::span<const std::byte> words);

  static constexpr std::size_t merged_max = 8;
  const TypeSupport* type_ = nullptr;
  std::vector<Wanted> wanted_;     ///< in the order of their hashes
  std::vector<FieldMask> merged_;  ///< unions met recently that contain a wanted mask
};

}  // namespace sft::udp
