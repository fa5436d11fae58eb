// Arbitrary bytes as an MCAP file. Everything that can be read is read, and no byte beyond the file is
// accessed. Each error has a text that names the fault.
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <stdexcept>

#include "tools/recording/mcap_reader.h"

namespace {

void require(bool condition, const char* what) {
  if (!condition) throw std::logic_error(what);  // libFuzzer reports it as a crash
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace sft::recording;
  const int descriptor = memfd_create("mcap", 0);
  require(write(descriptor, data, size) == static_cast<ssize_t>(size), "a file in memory is written");
  constexpr McapReader::Limits limits{.chunk_bytes = 1 << 20, .memory_bytes = 1 << 16, .text_bytes = 1 << 16};
  const auto reader = McapReader::open(File(descriptor, size, "input"), limits);
  if (!reader) return 0;
  std::size_t messages = 0;
  while (const auto message = (*reader)->next()) {
    require((*reader)->channels().contains(message->channel), "a message has a channel");
    ++messages;
  }
  require((*reader)->overview().messages == messages || (*reader)->faults().empty(),
          "damaged files are counted");
  (*reader)->check();
  for (const std::string& fault : (*reader)->faults()) require(!fault.empty(), "a fault has words");
  return 0;
}
