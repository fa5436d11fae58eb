// The masks, parts of fields and conditions that readers of this process request from a writer. The class
// finds the mask, parts and conditions that a datagram names.
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
  /// Sets the requested selections. `type` must outlive this object.
  void set(const TypeSupport& type, std::span<const Selection> selections);

  struct Named {
    /// The mask; null if no reader requests such samples. Valid until the next call.
    const FieldMask* mask = nullptr;
    std::uint64_t parts = 0;       ///< value of SampleBuffer::parts
    std::uint64_t conditions = 0;  ///< the hash of the conditions under which the sample is sent; 0: none
    bool malformed = false;
  };
  /// Returns the mask, parts and conditions that a first, whole or packed datagram names. Removes the mask's
  /// words from the payload of `d`.
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
  std::vector<Wanted> wanted_;     ///< sorted by hash
  std::vector<FieldMask> merged_;  ///< recent unions of masks that contain a wanted mask
};

}  // namespace sft::udp
