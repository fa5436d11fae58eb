#include "udp_transport/io/wake_event.h"

#include <sys/eventfd.h>

namespace sft::udp {

Result<core::FileDescriptor> open_wake_event() {
  core::FileDescriptor event(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!event)
    return fail(Errc::system, "cannot create an eventfd; raise the limit on open files (ulimit -n)");
  return event;
}

}  // namespace sft::udp
