// Samples that shared memory cannot take are sent by UDP, and arrive in order with the other samples. These
// are samples that are too large, and samples for which no chunk is free because readers hold all chunks.
// The publisher never fails for this reason.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <sft/sft.h>
#include <algorithm>
#include <atomic>
#include <fstream>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "tests/support/eventually.h"
#include "tests/support/isolated_host.h"

namespace sft::test {
namespace {

using sensor_msgs::msg::PointCloud2;
using F = PointCloud2::Field;
using namespace std::chrono_literals;

constexpr std::size_t small_bytes = 1'000;
constexpr std::size_t large_bytes = 1'000'000;
constexpr int chunks = 12;

/// A daemon with the given pools. The destructor kills it.
class SmallDaemon {
 public:
  explicit SmallDaemon(const std::string& pools) {
    std::ofstream("/tmp/sftd.toml") << pools;
    std::string words[] = {program_directory() + "/sftd", "--foreground", "--config=/tmp/sftd.toml"};
    char* arguments[] = {words[0].data(), words[1].data(), words[2].data(), nullptr};
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&quiet, 1, 2);
    if (posix_spawn(&pid_, arguments[0], &quiet, nullptr, arguments, environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&quiet);
  }
  ~SmallDaemon() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  SmallDaemon(const SmallDaemon&) = delete;
  SmallDaemon& operator=(const SmallDaemon&) = delete;

 private:
  pid_t pid_ = -1;
};

class FallbackTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!isolation_refusal().empty()) GTEST_SKIP() << isolation_refusal();
  }

  NodeOptions options(const std::string& name) {
    NodeOptions options{.name = name};
    options.shm.start_daemon = false;
    options.log = [this](LogLevel, std::string_view text) {
      const std::scoped_lock lock(mutex_);
      log_ += std::string(text) + '\n';
    };
    return options;
  }
  std::size_t logged(const std::string& text) {
    const std::scoped_lock lock(mutex_);
    std::size_t times = 0;
    for (std::size_t at = log_.find(text); at != std::string::npos; at = log_.find(text, at + 1)) ++times;
    return times;
  }

  template <class P>
  static bool all_served_by_shm(const P& publisher, std::size_t readers) {
    return eventually([&] {
      const auto known = publisher.status().readers;
      return known.size() == readers && std::ranges::all_of(known, [](const PublisherStatus::Reader& reader) {
               return reader.served && reader.transport == TransportKind::shm;
             });
    });
  }

  static PointCloud2 cloud(std::uint32_t number, std::size_t bytes) {
    PointCloud2 cloud;
    cloud.height = number;
    cloud.data.resize(bytes, static_cast<std::uint8_t>(number));
    return cloud;
  }

  std::mutex mutex_;
  std::string log_;
};

template <class S>
std::uint32_t height_of(S& subscriber) {
  const auto sample = subscriber.take();
  return sample ? sample->height() : 0;
}

template <class P>
PublisherStatus::Reader reader_of(const P& publisher) {
  return publisher.status().readers.at(0);
}

TEST_F(FallbackTest, ASampleLargerThanTheLargestChunkComesByUdpInItsPlace) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 200\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  std::atomic<std::uint64_t> reported{0};
  auto publisher = a.publisher<PointCloud2>("points", {.on_event =
                                                           [&](const Event& event) {
                                                             if (event.kind == Event::Kind::samples_diverted)
                                                               reported += event.count;
                                                           }})
                       .value();
  auto subscriber = b.subscriber<PointCloud2, F::height | F::data>("points", {.depth = 16}).value();
  ASSERT_TRUE(all_served_by_shm(publisher, 1));
  constexpr std::uint32_t rounds = 100;
  std::uint32_t number = 0;
  for (std::uint32_t round = 0; round < rounds; ++round) {
    for (const std::size_t bytes : {small_bytes, large_bytes, small_bytes, small_bytes})
      ASSERT_EQ(publisher.publish(cloud(++number, bytes)), PublishStatus::ok);
    for (std::uint32_t expected = number - 3; expected <= number; ++expected) {
      ASSERT_TRUE(subscriber.wait(hang_timeout)) << expected;
      const auto sample = subscriber.take();
      ASSERT_EQ(sample->height(), expected);
      const bool is_large = sample->data().size() == large_bytes;
      EXPECT_EQ(sample->data()[0], static_cast<std::uint8_t>(expected));
      EXPECT_EQ(sample.info().transport, is_large ? TransportKind::udp : TransportKind::shm);
    }
  }
  EXPECT_EQ(subscriber.status().lost, 0U);
  const PublisherStatus::Diverted diverted = publisher.status().diverted;
  EXPECT_EQ(diverted.too_large, rounds);
  EXPECT_EQ(diverted.total(), rounds);
  EXPECT_GE(diverted.too_large_bytes, large_bytes);
  EXPECT_LT(diverted.chunk_bytes, large_bytes);
  EXPECT_GE(diverted.chunk_bytes, small_bytes);
  EXPECT_EQ(publisher.status().dropped, 0U);
  const PublisherStatus::Reader reader = reader_of(publisher);
  EXPECT_EQ(reader.diverted, rounds);
  EXPECT_EQ(reader.sent, number);
  EXPECT_EQ(reader.published, number);
  const auto json = nlohmann::json::parse(to_json(a.snapshot())).at("publishers").at(0);
  EXPECT_EQ(json.at("diverted").at("too_large"), rounds);
  EXPECT_EQ(json.at("readers").at(0).at("diverted"), rounds);
  EXPECT_TRUE(eventually([&] { return reported == rounds; }));
  EXPECT_GE(logged("a sample of " + std::to_string(diverted.too_large_bytes) +
                   " bytes is larger than the largest chunk of shared memory, which has room for " +
                   std::to_string(diverted.chunk_bytes) + "; enlarge /dev/shm"),
            1U);
}

TEST_F(FallbackTest, WhatIsPublishedWhileNoChunkIsFreeComesByUdpInItsPlaceAndThenAgainInSharedMemory) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = " + std::to_string(chunks) + "\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 16}).value();
  ASSERT_TRUE(all_served_by_shm(publisher, 1));
  std::uint32_t number = 0;
  const auto pass_one_on = [&]() -> Sample<PointCloud2, F::height> {
    EXPECT_EQ(publisher.publish(cloud(++number, small_bytes)), PublishStatus::ok);
    EXPECT_TRUE(subscriber.wait(hang_timeout)) << number;
    auto sample = subscriber.take();
    EXPECT_EQ(sample->height(), number);
    return sample;
  };
  for (int round = 0; round < 3; ++round) {
    std::vector<Sample<PointCloud2, F::height>> held;
    for (int i = 0; i < 3 * chunks; ++i) held.push_back(pass_one_on());
    EXPECT_EQ(held.back().info().transport, TransportKind::udp);
    held.clear();
    const auto next = pass_one_on();
    EXPECT_EQ(next.info().transport, TransportKind::shm);
  }
  EXPECT_EQ(subscriber.status().lost, 0U);
  EXPECT_GT(publisher.status().diverted.exhausted, 3U * chunks);
  EXPECT_EQ(publisher.status().diverted.total(), reader_of(publisher).diverted);
  EXPECT_TRUE(eventually([&] { return logged("no chunk of that size is free") >= 1; })) << log_;
}

TEST_F(FallbackTest, AReliableReaderElsewhereThatStandsStillCostsReadersInMemoryNothing) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 128\ncount = 40\n");
  const pid_t remote = fork();
  ASSERT_GE(remote, 0);
  if (remote == 0) {
    NodeOptions udp{.name = "remote"};
    udp.transport = TransportChoice::udp;
    Node node = Node::open(udp).value();
    const auto subscriber =
        node.subscriber<PointCloud2, F::height | F::data>("points", {.reliability = reliable}).value();
    for (;;) pause();
  }
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  auto publisher = a.publisher<PointCloud2>("points", {.reliability = reliable}).value();
  auto subscriber =
      b.subscriber<PointCloud2, F::height | F::data>("points", {.reliability = reliable, .depth = 4}).value();
  const auto served = [&](TransportKind transport) {
    return std::ranges::count_if(publisher.status().readers, [&](const PublisherStatus::Reader& reader) {
      return reader.served && reader.transport == transport;
    });
  };
  EXPECT_TRUE(eventually([&] { return served(TransportKind::shm) == 1 && served(TransportKind::udp) == 1; }));
  kill(remote, SIGSTOP);
  for (std::uint32_t number = 1; number <= 300; ++number) {
    ASSERT_EQ(publisher.publish(cloud(number, 100'000)), PublishStatus::ok);
    ASSERT_TRUE(subscriber.wait(hang_timeout)) << number;
    const auto sample = subscriber.take();
    ASSERT_EQ(sample->height(), number);
    ASSERT_EQ(sample.info().transport, TransportKind::shm);
  }
  EXPECT_EQ(publisher.status().diverted, PublisherStatus::Diverted{});
  EXPECT_EQ(subscriber.status().lost, 0U);
  kill(remote, SIGKILL);
  waitpid(remote, nullptr, 0);
}

TEST_F(FallbackTest, ALoanIsLentAllTheSameAndArrives) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 12\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  auto publisher =
      a.publisher<PointCloud2>("points", {.reliability = reliable, .max_sample_bytes = 24 << 20}).value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.reliability = reliable}).value();
  auto all = b.subscriber<PointCloud2>("points", {.reliability = reliable}).value();
  ASSERT_TRUE(all_served_by_shm(publisher, 2));
  auto loan = publisher.loan({.height = 7}, {.data = 20 << 20}).value();
  loan->data().back() = 9;
  EXPECT_EQ(std::move(loan).publish(), PublishStatus::ok);
  ASSERT_TRUE(subscriber.wait(hang_timeout));
  EXPECT_EQ(height_of(subscriber), 7U);
  ASSERT_TRUE(all.wait(hang_timeout));
  const auto sample = all.take();
  EXPECT_EQ(sample->data().back(), 9);
}

TEST_F(FallbackTest, AReaderWithoutUdpMissesWhatIsTooLargeAndThatIsCounted) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 50\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto subscriber =
      b.subscriber<PointCloud2, F::height>("points", {.transport = TransportChoice::shm}).value();
  ASSERT_TRUE(all_served_by_shm(publisher, 1));
  EXPECT_EQ(publisher.publish(cloud(1, small_bytes)), PublishStatus::ok);
  EXPECT_EQ(publisher.publish(cloud(2, large_bytes)), PublishStatus::no_memory);
  EXPECT_EQ(publisher.publish(cloud(3, small_bytes)), PublishStatus::ok);
  for (const std::uint32_t expected : {1U, 3U}) {
    ASSERT_TRUE(subscriber.wait(hang_timeout));
    EXPECT_EQ(height_of(subscriber), expected);
  }
  EXPECT_EQ(subscriber.status().lost, 1U);
  EXPECT_EQ(reader_of(publisher).dropped, 1U);
  EXPECT_EQ(reader_of(publisher).diverted, 0U);
  EXPECT_EQ(publisher.status().diverted.too_large, 1U);
  EXPECT_EQ(publisher.status().diverted.total(), 1U);
}

// A durable publisher chooses the routes of a sample after it has added the sample to the history. So it
// updates its counts at another step than other publishers.
TEST_F(FallbackTest, ADurablePublisherCountsEachSampleOnceByWhicheverWayItGoes) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 200\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  auto publisher =
      a.publisher<PointCloud2>("points", {.durability = Durability::transient_local, .history_depth = 4})
          .value();
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  ASSERT_TRUE(all_served_by_shm(publisher, 1));
  std::uint32_t published = 0, diverted = 0;
  const auto publish_some = [&] {
    for (const std::size_t bytes : {small_bytes, large_bytes, small_bytes}) {
      ASSERT_EQ(publisher.publish(cloud(++published, bytes)), PublishStatus::ok);
      diverted += bytes == large_bytes ? 1 : 0;
      ASSERT_TRUE(subscriber.wait(hang_timeout));
      EXPECT_EQ(height_of(subscriber), published);
    }
  };
  for (int round = 0; round < 3; ++round) {
    publish_some();
    {
      auto other = b.subscriber<PointCloud2, F::width>("points", {.transport = TransportChoice::udp}).value();
      ASSERT_TRUE(eventually([&] {
        const auto readers = publisher.status().readers;
        return readers.size() == 2 && readers[0].served && readers[1].served;
      }));
      publish_some();
    }
    ASSERT_TRUE(all_served_by_shm(publisher, 1));
  }
  publish_some();
  const PublisherStatus::Reader reader = reader_of(publisher);
  EXPECT_EQ(reader.published, published);
  EXPECT_EQ(reader.sent, published);
  EXPECT_EQ(reader.diverted, diverted);
  EXPECT_EQ(subscriber.status().lost, 0U);
}

TEST_F(FallbackTest, OfSeveralWritersTheSamplesOfEachStayInOrderWhileBothPathsAreUsed) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 400\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  std::vector<Publisher<PointCloud2>> publishers;
  for (int i = 0; i < 3; ++i) publishers.push_back(a.publisher<PointCloud2>("points").value());
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 64}).value();
  for (auto& publisher : publishers) ASSERT_TRUE(all_served_by_shm(publisher, 1));
  constexpr std::uint32_t samples = 300;
  std::map<std::uint64_t, std::uint32_t> taken;
  const auto take_all = [&] {
    while (const auto sample = subscriber.take()) {
      EXPECT_EQ(sample->height(), taken[sample.info().writer] + 1);
      taken[sample.info().writer] = sample->height();
    }
    return std::ranges::count_if(taken, [](const auto& item) { return item.second == samples; }) == 3;
  };
  for (std::uint32_t number = 1; number <= samples; ++number) {
    for (std::size_t i = 0; i < publishers.size(); ++i) {
      const bool is_large = (number + i) % 5 == 0;
      publishers[i].publish(cloud(number, is_large ? large_bytes : small_bytes));
    }
    if (number % 4 == 0) {
      take_all();
      subscriber.wait(20ms);
    }
  }
  EXPECT_TRUE(eventually(take_all));
  EXPECT_EQ(subscriber.status().lost, 0U);
}

// ---- slow readers, and readers that hold samples ----

TEST_F(FallbackTest, ASlowReaderKnowsExactlyHowManySamplesOfEachWriterItMissed) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 200\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  std::vector<Publisher<PointCloud2>> publishers;
  for (int i = 0; i < 4; ++i) publishers.push_back(a.publisher<PointCloud2>("points").value());
  auto subscriber = b.subscriber<PointCloud2, F::height>("points", {.depth = 8}).value();
  for (auto& publisher : publishers) ASSERT_TRUE(all_served_by_shm(publisher, 1));
  std::uint32_t published = 0;
  std::map<std::uint64_t, std::uint64_t> received, lost;
  for (std::uint32_t burst : {1U, 5U, 8U, 9U, 40U, 1'000U, 3U}) {
    for (std::uint32_t i = 0; i < burst; ++i, ++published) {
      for (auto& publisher : publishers)
        ASSERT_EQ(publisher.publish(cloud(published + 1, small_bytes)), PublishStatus::ok);
    }
    while (const auto sample = subscriber.take()) {
      ++received[sample.info().writer];
      lost[sample.info().writer] += sample.info().lost_before;
      EXPECT_EQ(received[sample.info().writer] + lost[sample.info().writer], sample.info().sequence);
    }
  }
  const SubscriberStatus status = subscriber.status();
  EXPECT_EQ(status.writers.size(), publishers.size());
  for (const SubscriberStatus::Writer& writer : status.writers) {
    EXPECT_EQ(writer.received + writer.lost, published);
    EXPECT_EQ(writer.lost, 1U + 32U + 992U);
    EXPECT_EQ(lost[writer.id], writer.lost);
  }
  EXPECT_EQ(status.discarded, status.lost);
}

TEST_F(FallbackTest, AReaderThatHoldsTooManyIsToldAndCostsThePublisherAndOthersNothing) {
  const SmallDaemon daemon("[[pool]]\nsize_kib = 64\ncount = 60\n");
  Node a = Node::open(options("a")).value();
  Node b = Node::open(options("b")).value();
  std::atomic<int> reported{0};
  auto publisher = a.publisher<PointCloud2>("points").value();
  auto other = b.subscriber<PointCloud2, F::height>("points").value();
  auto holder =
      b.subscriber<PointCloud2, F::height>("points", {.depth = 8,
                                                      .max_held = 5,
                                                      .on_event =
                                                          [&](const Event& e) {
                                                            if (e.kind == Event::Kind::held_too_many)
                                                              ++reported;
                                                          }})
          .value();
  ASSERT_TRUE(all_served_by_shm(publisher, 2));
  std::vector<Sample<PointCloud2, F::height>> held;
  constexpr std::uint32_t published = 200;
  for (std::uint32_t number = 1; number <= published; ++number) {
    ASSERT_EQ(publisher.publish(cloud(number, small_bytes)), PublishStatus::ok);
    ASSERT_TRUE(other.wait(hang_timeout));
    EXPECT_EQ(height_of(other), number);
    if (auto sample = holder.take()) held.push_back(std::move(sample));
  }
  EXPECT_EQ(held.size(), 5U);
  EXPECT_TRUE(eventually([&] { return reported == 1; }));
  EXPECT_EQ(holder.status().held_too_many, 1U);
  EXPECT_EQ(logged("too many samples held"), 1U);
  EXPECT_EQ(publisher.status().diverted.total(), 0U);
  held.clear();
  std::uint32_t last = 0;
  while (const auto sample = holder.take()) last = sample->height();
  EXPECT_EQ(last, published);
  EXPECT_EQ(holder.status().received + holder.status().lost, published);
}

TEST_F(FallbackTest, ALimitOfHeldSamplesThatCannotWorkIsRefused) {
  Node node = Node::open(options("node")).value();
  for (const std::uint32_t limit : {0U, 1U, 257U})
    EXPECT_EQ((node.subscriber<PointCloud2, F::height>("points", {.max_held = limit}).error().code),
              Errc::invalid_argument);
}

}  // namespace
}  // namespace sft::test
