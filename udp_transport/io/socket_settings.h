// Functions that set the options of sockets.
#pragma once

#include <cstddef>

namespace sft::udp {

/// Calls setsockopt() with an integer. Returns false if the system refused the call.
bool set_int(int fd, int level, int name, int value);

/// Sets the size of a buffer. The system may grant less, up to its limit for this process. The size is in
/// bytes as the kernel counts them; 0 keeps the system's default.
void set_receive_buffer(int fd, std::size_t bytes);
void set_send_buffer(int fd, std::size_t bytes);

}  // namespace sft::udp
