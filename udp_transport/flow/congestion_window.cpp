#include "udp_transport/flow/congestion_window.h"

#include <algorithm>

namespace sft::udp {

void CongestionWindow::make_queue_short() { bytes_ = std::max(limits_.least_bytes, bytes_ / 4); }

/// Returns true if many of the datagrams since the previous report were lost.
bool CongestionWindow::lost_much(const FlowReport& report) const {
  const std::uint32_t sent = report.datagrams - datagrams_at_report_;
  const std::uint32_t came = report.came - came_at_report_;
  return came <= sent && sent - came > sent / 10 + 1;
}

/// Processes a report. A queue longer than tolerated, or many losses, show that the path is overloaded. Then
/// the window shrinks. Otherwise it grows if it has limited the sending.
void CongestionWindow::hear(const FlowReport& report, const Known& known) {
  const bool lost = known.counted && lost_much(report);
  datagrams_at_report_ = report.datagrams;
  came_at_report_ = report.came;
  if (lost || known.queueing > limits_.queueing) {
    // A report about data that was sent before the window shrank is ignored.
    if (report.position <= turned_at_) return;
    turned_at_ = known.sent;
    const std::size_t without_queue = lost ? 0 : std::min(known.taken, bytes_);
    bytes_ = std::max({limits_.least_bytes, bytes_ / 10 * 7, without_queue});
  } else if (report.position <= full_at_) {
    const auto came = static_cast<std::size_t>(report.position - known.reported);
    const std::size_t more = known.queueing < limits_.queueing / 4 ? came : came / 8;
    bytes_ = std::min(bytes_ + more, std::max(known.share, limits_.first_bytes));
  }
}

void CongestionWindow::begin_anew() {
  bytes_ = limits_.first_bytes;
  full_at_ = turned_at_ = 0;
}

}  // namespace sft::udp
