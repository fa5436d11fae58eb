#include "tools/hosts/interface_counters.h"

#include <fstream>
#include <iterator>
#include <sstream>

namespace sft::hosts {

std::optional<InterfaceBytes> interface_bytes(const std::string& interface) {
  std::ifstream file("/proc/self/net/dev");  // unlike /sys, this file shows the namespace of this process
  return parse_interface_bytes(std::string(std::istreambuf_iterator<char>(file), {}), interface);
}

std::optional<InterfaceBytes> parse_interface_bytes(const std::string& text, const std::string& interface) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    const std::size_t begin = line.find_first_not_of(' ');
    if (colon == std::string::npos || line.substr(begin, colon - begin) != interface) continue;
    std::istringstream figures(line.substr(colon + 1));
    InterfaceBytes bytes;
    std::uint64_t skipped = 0;
    figures >> bytes.received;
    for (int i = 0; i < 7; ++i)
      figures >> skipped;  // skips packets, errs, drop, fifo, frame, compressed, multicast
    figures >> bytes.sent;
    if (!figures.fail()) return bytes;
  }
  return std::nullopt;
}

}  // namespace sft::hosts
