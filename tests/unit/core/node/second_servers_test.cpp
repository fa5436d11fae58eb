// Tests when the log names a second server of a service.
#include "core/node/second_servers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sensor_msgs/msg/PointCloud2.hpp>
#include <utility>
#include <vector>

namespace sft::core {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class SecondServersTest : public ::testing::Test {
 protected:
  void serve(const std::string& topic, const std::string& type_name) {
    Endpoint e;
    e.id = ++last_id;
    e.role = Role::writer;
    e.topic = topic;
    e.type_name = type_name;
    table.add_ours(e, type);
    publishers.push_back({topic, "left"});
  }
  std::vector<std::string> said_after(std::chrono::seconds time) {
    return servers.look(
        table, [this](const std::string&) { return publishers; }, Time(1h) + time);
  }

  const TypeSupport type{detail::TypeTable<sensor_msgs::msg::PointCloud2>::type};
  EndpointTable table;
  std::vector<Discovery::KnownPublisher> publishers;
  SecondServers servers;
  EndpointId last_id = 0;
};

TEST_F(SecondServersTest, ASecondServerIsNamedOnceItHasBeenThereForAWhile) {
  serve("sum/reply", "service_msgs::srv::Add_Reply");
  EXPECT_THAT(said_after(0s), IsEmpty());
  publishers.push_back({"sum/reply", "right"});
  EXPECT_THAT(said_after(8s), IsEmpty()) << "the one of a process that was killed is noticed soon";
  EXPECT_THAT(
      said_after(16s),
      ElementsAre(HasSubstr("service 'sum' has 2 servers, on the nodes 'left', 'right', and clients call "
                            "none of them: end all but one")));
  publishers.pop_back();
  EXPECT_THAT(said_after(1000s), IsEmpty());
}

TEST_F(SecondServersTest, TopicsThatAreNoServiceHaveAsManyPublishersAsTheyLike) {
  serve("sum/reply", "service_msgs::msg::Missed_Reply");
  serve("sum", "service_msgs::srv::Add_Reply");
  for (const char* const topic : {"sum/reply", "sum"}) publishers.push_back({topic, "right"});
  for (const auto time : {0s, 8s, 16s}) EXPECT_THAT(said_after(time), IsEmpty());
}

TEST_F(SecondServersTest, OtherServicesOfTheTypeAreOthers) {
  serve("sum/reply", "service_msgs::srv::Add_Reply");
  publishers.push_back({"product/reply", "right"});
  for (const auto time : {0s, 8s, 16s}) EXPECT_THAT(said_after(time), IsEmpty());
}

}  // namespace
}  // namespace sft::core
