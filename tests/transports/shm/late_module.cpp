// A shared library that contains SFT. A program loads the library at run time.
#include <chrono>
#include <string>

#include "shm_transport/host/replaced_functions.h"
#include "shm_transport/shm_transport.h"

extern "C" {

bool functions_are_replaced() { return sft::shm::functions_are_replaced(); }

/// Returns the reason why shared memory cannot be used. Starts no daemon.
const char* shared_memory() {
  static std::string text;
  sft::shm::ShmOptions options;
  options.start_daemon = false;
  const auto transport = sft::shm::open_shm_transport(options);
  if (!transport) return "no transport";
  (*transport)->poll(std::chrono::steady_clock::now());
  text = (*transport)->description();
  return text.c_str();
}

}  // end of extern "C"
