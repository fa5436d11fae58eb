// The messages between the sides of a run: JSON in samples of std_msgs/String. The side that sends
// publishes an offer, again for each mark, which the other sides answer with a report.
#pragma once

#include <sft/sft.h>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/perf/sequence.h"
#include "tools/perf/usage.h"

namespace sft::perf {

inline constexpr const char* offer_topic = "sft_perf/offer";

struct Offer {
  std::uint32_t version = 1;
  std::uint64_t session = 0;  ///< random, also the token of plain sockets
  std::uint64_t mark = 0;     ///< 0: the run has not begun; grows with each report that is wanted
  bool ends = false;
  std::string type{};
  std::string definition{};           ///< as .msg text
  std::vector<std::string> fields{};  ///< a stream of its own for each selection
  TransportChoice transport = TransportChoice::automatic;
  bool reliable = false;
  bool answers = true;  ///< false: samples are only counted
  bool loans = false;   ///< answers are loans, too
  bool udp = false, tcp = false;
};

struct Report {
  /// The state of one stream.
  struct Stream {
    std::uint64_t publisher = 0;  ///< of the answers: SampleInfo::writer
    std::uint64_t received = 0;
    std::uint64_t lost = 0;   ///< as the subscriber counts
    std::vector<Part> parts;  ///< of the answers since the last mark
  };
  std::uint32_t version = 1;
  std::uint64_t session = 0;
  std::uint64_t side = 0;  ///< a random number that identifies the side
  std::uint64_t mark = 0;
  std::string error{};
  HostClock clock{};
  Usage usage{};  ///< since the process began
  std::vector<Stream> streams{};
  std::uint64_t udp_port = 0, tcp_port = 0;
  std::uint64_t udp_received = 0, tcp_received = 0;
};

std::string text_of(const Offer& offer);
std::string text_of(const Report& report);
/// Return nothing if the text is not of this program. It may be hostile.
std::optional<Offer> offer_of(std::string_view text);
std::optional<Report> report_of(std::string_view text);

/// Names of the topics of one session.
std::string topic_of(std::uint64_t session, std::string_view part);

/// The type of offers and reports.
DynamicType text_type();
Result<void> publish_text(DynamicPublisher& publisher, const std::string& text);
/// Returns the text of the next sample; nothing if there is none.
std::optional<std::string> take_text(DynamicSubscriber& subscriber);

/// Reliable, with the last sample for sides that come later.
PublisherOptions retained();

/// Returns a number other than 0 that cannot be guessed.
std::uint64_t random_number();

}  // namespace sft::perf
