// The messages between the sides of a run: JSON in samples of std_msgs/String. The sending side publishes
// an offer. It publishes the offer again with each new mark, and the other sides answer with a report.
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
  std::uint64_t session = 0;  ///< a random number, which is also the token of plain sockets
  std::uint64_t mark = 0;     ///< the number of the report that is requested; 0: the run has not begun
  bool ends = false;
  std::string type{};
  std::string definition{};           ///< the definition of the type as .msg text
  std::vector<std::string> fields{};  ///< the selections, each of which has its own stream of samples
  TransportChoice transport = TransportChoice::automatic;
  bool reliable = false;
  bool answers = true;  ///< false: samples are only counted
  bool loans = false;   ///< true: answers are loans, too
  bool udp = false, tcp = false;
};

struct Report {
  /// The state of one stream.
  struct Stream {
    std::uint64_t publisher = 0;  ///< the id of the publisher of answers (SampleInfo::writer)
    std::uint64_t received = 0;
    std::uint64_t lost = 0;   ///< the losses that the subscriber has counted
    std::vector<Part> parts;  ///< the parts of the answers since the last mark
  };
  std::uint32_t version = 1;
  std::uint64_t session = 0;
  std::uint64_t side = 0;  ///< a random number that identifies the side
  std::uint64_t mark = 0;
  std::string error{};
  HostClock clock{};
  Usage usage{};  ///< the usage since the process began
  std::vector<Stream> streams{};
  std::uint64_t udp_port = 0, tcp_port = 0;
  std::uint64_t udp_received = 0, tcp_received = 0;
};

std::string text_of(const Offer& offer);
std::string text_of(const Report& report);
/// Return the message; nothing if the text is not a message of this program. The text may be hostile.
std::optional<Offer> offer_of(std::string_view text);
std::optional<Report> report_of(std::string_view text);

/// Returns the name of a topic of the session.
std::string topic_of(std::uint64_t session, std::string_view part);

/// Returns the type of offers and reports.
DynamicType text_type();
Result<void> publish_text(DynamicPublisher& publisher, const std::string& text);
/// Returns the text of the next sample; nothing if there is none.
std::optional<std::string> take_text(DynamicSubscriber& subscriber);

/// Returns options for a reliable publisher that retains its last sample for sides that join later.
PublisherOptions retained();

/// Returns a number other than 0 that cannot be guessed.
std::uint64_t random_number();

}  // namespace sft::perf
