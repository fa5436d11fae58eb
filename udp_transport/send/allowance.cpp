#include "udp_transport/send/allowance.h"

#include <algorithm>

namespace sft::udp {

std::size_t allowance(Destination& to, RateLimit& of_writer, RateLimit& of_all, ResendWindow::Size size,
                      Destination::Time now) {
  const bool small = size == ResendWindow::Size::small;
  if (!of_writer.ready(small, now) || !of_all.ready(small, now)) return 0;
  const std::size_t room = to.room(small ? Destination::Size::small : Destination::Size::large, now);
  return std::min({room, of_writer.batch_bytes(), of_all.batch_bytes()});
}

}  // namespace sft::udp
