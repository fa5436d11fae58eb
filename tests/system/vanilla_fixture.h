// Nodes of plain DDS, which know nothing of SFT, on emulated hosts, and nodes of SFT in this process.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/platform/domain_id.h"
#include "core/platform/file_descriptor.h"
#include "tests/support/encoded.h"
#include "tests/support/isolated_host.h"
#include "tests/system/fixture.h"
#include "tools/hosts/network.h"

namespace sft::test {

using VanillaDds = NodeOptions::VanillaDds;

/// A program on a host whose input and output are pipes. Its first argument is the DDS domain.
class VanillaProcess {
 public:
  VanillaProcess(const hosts::NetworkNamespace& host, const std::string& name,
                 std::vector<std::string> arguments) {
    int input[2], output[2];
    EXPECT_EQ(pipe2(input, O_CLOEXEC) + pipe2(output, O_CLOEXEC), 0);
    const std::string program = program_directory() + "/" + name;
    arguments.insert(arguments.begin(), {program, std::to_string(domain())});
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      dup2(input[0], STDIN_FILENO);
      dup2(output[1], STDOUT_FILENO);
      if (host.enter()) execv(program.c_str(), words.data());
      _exit(1);
    }
    close(input[0]);
    close(output[1]);
    input_ = core::FileDescriptor(input[1]);
    output_ = core::FileDescriptor(output[0]);
  }
  ~VanillaProcess() { kill_now(); }
  VanillaProcess(const VanillaProcess&) = delete;
  VanillaProcess& operator=(const VanillaProcess&) = delete;

  static std::uint32_t domain() { return core::domain_id({}, std::getenv("ROS_DOMAIN_ID")).value(); }

  void kill_now() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
  }
  /// The program ends by itself once it has read all of its input.
  void end() {
    input_ = core::FileDescriptor();
    waitpid(std::exchange(process_, -1), nullptr, 0);
  }
  void hold_up() const { kill(process_, SIGSTOP); }
  void let_go() const { kill(process_, SIGCONT); }

 protected:
  bool read_all(void* to, std::size_t bytes) {
    for (std::size_t done = 0; done < bytes;) {
      const ssize_t n = read(output_.get(), static_cast<std::byte*>(to) + done, bytes - done);
      if (n <= 0) return false;
      done += static_cast<std::size_t>(n);
    }
    return true;
  }
  bool is_readable(std::chrono::milliseconds within) const {
    pollfd ready{output_.get(), POLLIN, 0};
    return poll(&ready, 1, static_cast<int>(within.count())) > 0;
  }
  void write_all(const void* bytes, std::size_t size) const {
    for (std::size_t done = 0; done < size;) {
      const ssize_t n = write(input_.get(), static_cast<const std::byte*>(bytes) + done, size - done);
      ASSERT_GT(n, 0);
      done += static_cast<std::size_t>(n);
    }
  }

 private:
  pid_t process_ = -1;
  core::FileDescriptor input_, output_;
};

/// A process of vanilla_reader.
class VanillaReader : public VanillaProcess {
 public:
  struct How {
    std::string topic = "rt/points";
    std::string reliability = "reliable", durability = "volatile";
    int depth = 10;
    std::string kind = "plain";
  };
  VanillaReader(const hosts::NetworkNamespace& host, const How& how)
      : VanillaProcess(host, "vanilla_reader",
                       {how.topic, how.reliability, how.durability, std::to_string(how.depth), how.kind}) {}

  struct Sample {
    std::vector<std::byte> body;  ///< without padding
    std::chrono::nanoseconds stamp{0};
  };
  /// The next one; empty if none comes.
  Sample take() {
    while (samples_.empty() && read_record(hang_timeout)) continue;
    if (samples_.empty()) return {};
    Sample sample = std::move(samples_.front());
    samples_.erase(samples_.begin());
    return sample;
  }
  /// Waits until that number of writers matches.
  bool matches(std::uint32_t writers) {
    while (matched_ != writers && read_record(hang_timeout)) continue;
    return matched_ == writers;
  }
  /// The number of matching writers, as reported last.
  std::uint32_t matched() {
    while (read_record(std::chrono::milliseconds(0))) continue;
    return matched_;
  }

 private:
  struct Head {
    std::int64_t stamp = 0;
    std::uint32_t kind = 0, bytes = 0;
  };
  bool read_record(std::chrono::milliseconds within) {
    Head head;
    if (!is_readable(within) || !read_all(&head, sizeof head)) return false;
    std::vector<std::byte> bytes(head.bytes);
    if (!read_all(bytes.data(), bytes.size())) return false;
    if (head.kind == 1) {
      std::memcpy(&matched_, bytes.data(), sizeof matched_);
    } else {
      const std::size_t padding = std::to_integer<std::size_t>(bytes.at(3)) & 3;
      samples_.push_back({{bytes.begin() + 4, bytes.end() - static_cast<long>(padding)},
                          std::chrono::nanoseconds(head.stamp)});
    }
    return true;
  }

  std::uint32_t matched_ = 0;
  std::vector<Sample> samples_;
};

/// A process of vanilla_writer.
class VanillaWriter : public VanillaProcess {
 public:
  struct How {
    std::string topic = "rt/points";
    std::string reliability = "reliable", durability = "volatile";
    int depth = 10;
    std::string kind = "plain";
  };
  VanillaWriter(const hosts::NetworkNamespace& host, const How& how)
      : VanillaProcess(host, "vanilla_writer",
                       {how.topic, how.reliability, how.durability, std::to_string(how.depth), how.kind}) {}

  /// The message is VanillaTest::cloud().
  void write_cloud(std::uint32_t number, std::size_t bytes = 1000) const {
    const std::string line = std::to_string(number) + " " + std::to_string(bytes) + "\n";
    write_all(line.data(), line.size());
  }
  /// Waits until that number of readers matches.
  bool matches(std::uint32_t readers) {
    while (matched_ != readers && read_matched(hang_timeout)) continue;
    return matched_ == readers;
  }
  /// Returns the number of matching readers, as reported last.
  std::uint32_t matched() {
    while (read_matched(std::chrono::milliseconds(0))) continue;
    return matched_;
  }

 private:
  bool read_matched(std::chrono::milliseconds within) {
    return is_readable(within) && read_all(&matched_, sizeof matched_);
  }
  std::uint32_t matched_ = 0;
};

/// A process of vanilla_echo or fast_dds_echo, which sends the messages of "points" back as "echoed".
class VanillaEcho : public VanillaProcess {
 public:
  struct How {
    std::string program = "vanilla_echo";
    std::string reliability = "reliable", durability = "volatile";
    int depth = 10;
  };
  VanillaEcho(const hosts::NetworkNamespace& host, const How& how)
      : VanillaProcess(
            host, how.program,
            {"rt/points", "rt/echoed", how.reliability, how.durability, std::to_string(how.depth)}) {}
  /// Waits until that number of endpoints matches its reader and its writer.
  bool matches(std::uint32_t endpoints) {
    while (matched_ != endpoints && is_readable(hang_timeout) && read_all(&matched_, sizeof matched_))
      continue;
    return matched_ == endpoints;
  }

 private:
  std::uint32_t matched_ = 0;
};

/// A process of vanilla_joins: nodes that come and go.
class VanillaJoins : public VanillaProcess {
 public:
  VanillaJoins(const hosts::NetworkNamespace& host, const std::string& topic)
      : VanillaProcess(host, "vanilla_joins", {topic}) {}
  /// Waits until that many nodes have come, have written a cloud with that number, and have left. Returns how
  /// many of them were matched, as far as they can be.
  std::uint32_t join(std::uint32_t number, std::uint64_t nodes) {
    const std::string line = std::to_string(number) + " " + std::to_string(nodes) + "\n";
    write_all(line.data(), line.size());
    std::uint32_t joined = 0;
    return read_all(&joined, sizeof joined) ? joined : 0;
  }
};

/// A process of vanilla_many, with the given numbers of nodes and of pairs of a reader and a writer that send
/// clouds back.
class VanillaMany : public VanillaProcess {
 public:
  VanillaMany(const hosts::NetworkNamespace& host, std::size_t nodes, std::size_t pairs)
      : VanillaProcess(host, "vanilla_many", {std::to_string(nodes), std::to_string(pairs)}) {}
  /// Waits until all are there.
  bool is_ready() {
    std::uint32_t made = 0;
    return is_readable(hang_timeout) && read_all(&made, sizeof made);
  }
};

/// A process of vanilla_forger, which writes any bytes that the test gives it as a sample of the topic.
class VanillaForger : public VanillaProcess {
 public:
  explicit VanillaForger(const hosts::NetworkNamespace& host, const std::string& topic = "rt/points",
                         const std::string& type = "sensor_msgs::msg::dds_::PointCloud2_")
      : VanillaProcess(host, "vanilla_forger", {topic, type}) {}
  void write_sample(const std::vector<std::byte>& bytes) const {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    write_all(&size, sizeof size);
    write_all(bytes.data(), bytes.size());
  }
  bool is_matched() { return is_readable(hang_timeout) && read_all(&matched_, sizeof matched_); }

 private:
  std::uint32_t matched_ = 0;
};

/// The nodes of SFT are on the first of two hosts.
class VanillaTest : public ::testing::Test {
 protected:
  VanillaTest() {
    warnings_expected = false;
    expected_warning = nullptr;
    EXPECT_TRUE(network_.host(0).enter());
    use_lease("2 s");
  }
  /// For all nodes: after this time one that was killed is gone.
  static void use_lease(const std::string& lease) {
    const std::string config = "<Discovery><LeaseDuration>" + lease +
                               "</></>,<Internal><SocketReceiveBufferSize min=\"default\" max=\"4MB\"/></>";
    setenv("CYCLONEDDS_URI", config.c_str(), 1);
  }
  Node open(Way way, VanillaDds choice = VanillaDds::automatic) {
    NodeOptions options = node_options(way, "camera");
    options.vanilla_dds = choice;
    return Node::open(options).value();
  }
  static NodeOptions with_plain_names(NodeOptions options) {
    options.vanilla_dds = VanillaDds::always;
    options.dds_names = NodeOptions::DdsNames::plain;
    return options;
  }
  template <class P>
  static bool serves(const P& publisher, std::size_t readers) {
    return eventually([&] { return publisher.status().vanilla_readers == readers; });
  }
  template <class S>
  static bool hears(const S& subscriber, std::ptrdiff_t writers) {
    return eventually([&] {
      const SubscriberStatus status = subscriber.status();
      return std::ranges::count_if(status.writers, &SubscriberStatus::Writer::connected) == writers;
    });
  }
  static PointCloud2 cloud(std::uint32_t number, std::size_t bytes = 1000) {
    PointCloud2 c;
    c.header.stamp.sec = static_cast<std::int32_t>(number);
    c.header.frame_id = "lidar";
    c.height = number;
    c.width = number + 1;
    c.point_step = 10;
    c.row_step = 10 * c.width;
    c.fields.resize(2);
    c.fields[1].name = "y";
    c.data.resize(bytes);
    for (std::size_t i = 0; i < bytes; i += 97) c.data[i] = static_cast<std::uint8_t>(i + number);
    return c;
  }
  static std::vector<std::byte> body_of(const PointCloud2& message) { return Encoded(message).bytes(); }
  /// Returns options whose log collects the warnings.
  NodeOptions options_with_log(Way way = Way::udp) {
    NodeOptions options = node_options(way, "camera");
    options.log = [this](LogLevel level, std::string_view line) {
      const std::lock_guard lock(mutex_);
      if (level == LogLevel::warning) warnings_.emplace_back(line);
    };
    return options;
  }
  std::ptrdiff_t warnings_with(const std::string& part) {
    const std::lock_guard lock(mutex_);
    return std::ranges::count_if(warnings_,
                                 [&](const std::string& line) { return line.find(part) != line.npos; });
  }
  bool warns_of(const std::string& part) {
    return eventually([&] { return warnings_with(part) > 0; });
  }

  std::mutex mutex_;
  std::vector<std::string> warnings_;
  const hosts::EmulatedNetwork network_ = hosts::EmulatedNetwork::create(2).value();
};

}  // namespace sft::test
