/* A node of plain Cyclone DDS in the graph of ROS 2, as rmw_cyclonedds makes one; it knows nothing of SFT. It
   is compiled for each size that GUIDs have in that graph. It has a writer of clouds, and reads words from
   its standard input:

   speak: from now on it tells the others its name, and that the writer is its own.
   list:  writes what `ros2 node list` and `ros2 topic info -v` would show, to its standard output: lines
            node NAME
            reader|writer TOPIC TYPE RELIABILITY DURABILITY PARTITION HASH NODE
            end
          with - in place of what is empty. Endpoints of its own and those of the graph are left out.
   leave: it tells that it has no node any more, and ends.

   ros_node_16|ros_node_24 DOMAIN NAMESPACE NAME TOPIC */
#include <dds/dds.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>

#include ROS_GRAPH_HEADER
#include "vanilla_messages.h"

typedef rmw_dds_common_msg_dds__ParticipantEntitiesInfo_ Info;
typedef rmw_dds_common_msg_dds__NodeEntitiesInfo_ NodeInfo;
typedef rmw_dds_common_msg_dds__Gid_ Gid;
enum { known_max = 64 };

static dds_entity_t participant, infos, info_writer, cloud_writer;
static Info* known[known_max]; /* the last one of each participant */

static dds_qos_t* qos_of_graph(dds_history_kind_t history) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_INFINITY);
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_durability_service(qos, 0, DDS_HISTORY_KEEP_LAST, 1, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED);
  dds_qset_history(qos, history, history == DDS_HISTORY_KEEP_LAST ? 1 : 0);
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

static Gid gid_of(dds_entity_t entity) {
  dds_guid_t guid;
  Gid gid = {{0}};
  dds_get_guid(entity, &guid);
  memcpy(gid.data_, guid.v, sizeof guid.v);
  return gid;
}

static void show_node(const char* name_space, const char* name, bool has_node) {
  Gid writer = gid_of(cloud_writer);
  NodeInfo node;
  memset(&node, 0, sizeof node);
  strncpy(node.node_namespace_, name_space, sizeof node.node_namespace_ - 1);
  strncpy(node.node_name_, name, sizeof node.node_name_ - 1);
  node.writer_gid_seq_._buffer = &writer;
  node.writer_gid_seq_._length = node.writer_gid_seq_._maximum = 1;
  Info info = {.gid_ = gid_of(participant)};
  info.node_entities_info_seq_._buffer = &node;
  info.node_entities_info_seq_._length = info.node_entities_info_seq_._maximum = has_node ? 1 : 0;
  if (dds_write(info_writer, &info) != DDS_RETCODE_OK) exit(4);
}

static void keep(Info* info) {
  for (int i = 0; i < known_max; ++i) {
    const bool is_same = known[i] != NULL && memcmp(&known[i]->gid_, &info->gid_, sizeof info->gid_) == 0;
    if (is_same)
      dds_sample_free(known[i], &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, DDS_FREE_ALL);
    if (is_same || known[i] == NULL) {
      known[i] = info;
      return;
    }
  }
  exit(5);
}

static void take_infos(void) {
  for (;;) {
    void* info = dds_alloc(sizeof(Info));
    memset(info, 0, sizeof(Info));
    dds_sample_info_t state;
    if (dds_take(infos, &info, &state, 1, 1) <= 0) return;
    if (state.valid_data) keep(info);
  }
}

static bool is_in(const void* sequence, const dds_guid_t* guid) {
  const dds_sequence_rmw_dds_common_msg_dds__Gid_* gids = sequence;
  for (uint32_t i = 0; i < gids->_length; ++i)
    if (memcmp(gids->_buffer[i].data_, guid->v, sizeof guid->v) == 0) return true;
  return false;
}

/* Calls for each node whose participant is there. */
static void for_each_node(void (*use)(const NodeInfo*, const void*, bool), const void* data, bool flag) {
  const dds_entity_t all = dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, NULL, NULL);
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(all, &sample, &info, 1, 1) > 0) {
    const dds_builtintopic_participant_t* one = sample;
    for (int i = 0; i < known_max && known[i] != NULL && info.valid_data; ++i) {
      if (memcmp(known[i]->gid_.data_, one->key.v, sizeof one->key.v) != 0) continue;
      for (uint32_t n = 0; n < known[i]->node_entities_info_seq_._length; ++n)
        use(&known[i]->node_entities_info_seq_._buffer[n], data, flag);
    }
    dds_return_loan(all, &sample, 1);
    sample = NULL;
  }
  dds_delete(all);
}

static void print_name(const NodeInfo* node) {
  printf("%s/%s", strcmp(node->node_namespace_, "/") == 0 ? "" : node->node_namespace_, node->node_name_);
}

static void print_node(const NodeInfo* node, const void* unused, bool unused_flag) {
  (void)unused;
  (void)unused_flag;
  printf("node ");
  print_name(node);
  puts("");
}

static void print_owner(const NodeInfo* node, const void* guid, bool is_reader) {
  if (!is_in(is_reader ? (const void*)&node->reader_gid_seq_ : (const void*)&node->writer_gid_seq_, guid))
    return;
  print_name(node);
}

/* The hash in the user data, up to the semicolon behind it. */
static void print_hash(const char* data, size_t bytes) {
  const char* key = "typehash=";
  for (size_t at = 0; at + strlen(key) <= bytes; ++at) {
    if (memcmp(data + at, key, strlen(key)) != 0) continue;
    for (at += strlen(key); at < bytes && data[at] != ';'; ++at) putchar(data[at]);
    return;
  }
  putchar('-');
}

static void print_endpoint(const dds_builtintopic_endpoint_t* endpoint, bool is_reader) {
  void* data = NULL;
  size_t bytes = 0;
  dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
  dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
  uint32_t partitions = 0;
  char** names = NULL;
  dds_qget_userdata(endpoint->qos, &data, &bytes);
  dds_qget_reliability(endpoint->qos, &reliability, NULL);
  dds_qget_durability(endpoint->qos, &durability);
  dds_qget_partition(endpoint->qos, &partitions, &names);
  printf("%s %s %s %s %s %s ", is_reader ? "reader" : "writer", endpoint->topic_name, endpoint->type_name,
         reliability == DDS_RELIABILITY_RELIABLE ? "reliable" : "best_effort",
         durability == DDS_DURABILITY_VOLATILE ? "volatile" : "latched", partitions == 0 ? "-" : names[0]);
  print_hash(data, bytes);
  putchar(' ');
  for_each_node(print_owner, &endpoint->key, is_reader);
  puts("");
  for (uint32_t i = 0; i < partitions; ++i) dds_free(names[i]);
  dds_free(names);
  dds_free(data);
}

static void print_endpoints(dds_entity_t builtin_topic, bool is_reader) {
  const dds_entity_t all = dds_create_reader(participant, builtin_topic, NULL, NULL);
  dds_guid_t own;
  dds_get_guid(participant, &own);
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(all, &sample, &info, 1, 1) > 0) {
    const dds_builtintopic_endpoint_t* one = sample;
    if (info.valid_data && memcmp(one->participant_key.v, own.v, sizeof own.v) != 0 &&
        strcmp(one->topic_name, "ros_discovery_info") != 0 && strncmp(one->topic_name, "DCPS", 4) != 0)
      print_endpoint(one, is_reader);
    dds_return_loan(all, &sample, 1);
    sample = NULL;
  }
  dds_delete(all);
}

static void list(void) {
  take_infos();
  for_each_node(print_node, NULL, false);
  print_endpoints(DDS_BUILTIN_TOPIC_DCPSSUBSCRIPTION, true);
  print_endpoints(DDS_BUILTIN_TOPIC_DCPSPUBLICATION, false);
  puts("end");
  fflush(stdout);
}

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_userdata(qos, "enclave=/;", strlen("enclave=/;"));
  participant = dds_create_participant((dds_domainid_t)atoi(argv[1]), qos, NULL);
  const dds_entity_t graph = dds_create_topic(
      participant, &rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc, "ros_discovery_info", NULL, NULL);
  infos = dds_create_reader(participant, graph, qos_of_graph(DDS_HISTORY_KEEP_ALL), NULL);
  info_writer = dds_create_writer(participant, graph, qos_of_graph(DDS_HISTORY_KEEP_LAST), NULL);
  const dds_entity_t clouds =
      dds_create_topic(participant, &sensor_msgs_msg_dds__PointCloud2__desc, argv[4], NULL, NULL);
  cloud_writer = dds_create_writer(participant, clouds, NULL, NULL);
  if (infos < 0 || info_writer < 0 || cloud_writer < 0) return 3;
  char word[16];
  while (scanf("%15s", word) == 1) {
    if (strcmp(word, "speak") == 0) show_node(argv[2], argv[3], true);
    if (strcmp(word, "list") == 0) list();
    if (strcmp(word, "leave") == 0) break;
  }
  show_node(argv[2], argv[3], false);
  dds_delete(participant);
  return 0;
}
