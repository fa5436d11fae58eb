// Judges by the acks of a channel whether long datagrams arrive: a path may drop these although short ones,
// as acks are, get through. Looks at the samples that do not fit into one datagram. Pure.
#pragma once

#include <cstddef>
#include <cstdint>

#include "udp_transport/reliable/resend_window.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class LengthWatch {
 public:
  struct Verdict {
    bool arrived = false;  ///< told only while the length is in doubt
    bool lost = false;     ///< all long datagrams of the sample that is missing first are asked for
  };
  /// The window has not heard the ack yet. `length` is that of datagrams now. It is in doubt while nothing
  /// has shown that datagrams of this length arrive.
  Verdict judge(const Ack& ack, const ResendWindow& window, std::size_t length, bool is_in_doubt);

 private:
  bool some_arrived(const Ack& ack, const ResendWindow& window);

  std::size_t length_ = 0;          ///< when an ack came last
  std::uint64_t sent_so_from_ = 0;  ///< the first ordinal surely sent in such datagrams, and not judged
};

}  // namespace sft::udp
