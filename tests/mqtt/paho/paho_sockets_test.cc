// The system calls that paho_sockets.cc stands in for, as everybody else sees them.
#include "mqtt/paho/paho_sockets.h"

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using std::chrono::milliseconds;

struct Pair {
  Pair() {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, ends.data()) != 0) std::abort();
    ours = Descriptor(ends[0]);
    theirs = Descriptor(ends[1]);
  }
  Descriptor ours;
  Descriptor theirs;
};

int PollForReading(int descriptor, int timeout) {
  pollfd waiting{descriptor, POLLIN, 0};
  return poll(&waiting, 1, timeout);
}

ssize_t WriteTwo(int descriptor, std::string first, std::string second) {
  const iovec parts[] = {{first.data(), first.size()}, {second.data(), second.size()}};
  return writev(descriptor, parts, 2);
}

class PahoSockets : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!PahoCall::Supported()) GTEST_SKIP() << "FLEETPUB_FAST_CONNECT is off";
  }
};

TEST(WithoutAPahoCall, PollConnectAndWritevAreTheSystems) {
  const Pair pair;
  EXPECT_EQ(PollForReading(pair.ours.get(), 0), 0);
  EXPECT_EQ(PollForReading(-1, 0), 0);
  pollfd bad{987'654, POLLIN, 0};
  EXPECT_EQ(poll(&bad, 1, 0), 1);
  EXPECT_EQ(bad.revents, POLLNVAL);
  EXPECT_EQ(WriteTwo(pair.ours.get(), "ab", "cd"), 4);
  EXPECT_EQ(PollForReading(pair.theirs.get(), 0), 1);
  EXPECT_EQ(connect(-1, nullptr, 0), -1);
  EXPECT_EQ(errno, EBADF);
  addrinfo* list = nullptr;
  ASSERT_EQ(getaddrinfo("127.0.0.1", "7", nullptr, &list), 0);
  EXPECT_EQ(ntohs(reinterpret_cast<sockaddr_in*>(list->ai_addr)->sin_port), 7);
  freeaddrinfo(list);
}

TEST_F(PahoSockets, PutsTheConnectedSocketInPlace) {
  Pair pair;
  const Descriptor pahos(socket(AF_INET, SOCK_STREAM, 0));
  PahoCall call(-1, Soon());
  call.Adopt(std::move(pair.ours));
  EXPECT_EQ(connect(pahos.get(), nullptr, 0), -1);
  EXPECT_EQ(errno, EINPROGRESS);
  EXPECT_EQ(call.descriptor(), pahos.get());
  EXPECT_EQ(WriteTwo(pahos.get(), "a", "b"), 2);
  char read[2];
  EXPECT_EQ(recv(pair.theirs.get(), read, 2, 0), 2);
}

TEST_F(PahoSockets, AnswersTheFirstPollAtOnceAndOnlyThat) {
  Pair pair;
  const Descriptor pahos(socket(AF_INET, SOCK_STREAM, 0));
  PahoCall call(-1, Soon());
  call.Adopt(std::move(pair.ours));
  static_cast<void>(connect(pahos.get(), nullptr, 0));
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(PollForReading(pahos.get(), 60'000), 0);
  EXPECT_EQ(PollForReading(pahos.get(), 30), 0);
  EXPECT_GE(std::chrono::steady_clock::now() - start, milliseconds(30));
}

TEST_F(PahoSockets, ShutsTheConnectionDownAtTheDeadline) {
  const Pair pair;
  const PahoCall call(pair.ours.get(), In(milliseconds(20)));
  EXPECT_EQ(PollForReading(pair.ours.get(), 60'000), 0);
  EXPECT_EQ(PollForReading(pair.ours.get(), 60'000), 1);
  EXPECT_TRUE(call.expired());
  char byte = 0;
  EXPECT_EQ(recv(pair.ours.get(), &byte, 1, 0), 0);
}

TEST_F(PahoSockets, LeavesOtherDescriptorsAndOtherThreadsAlone) {
  const Pair pair;
  const Pair other;
  const PahoCall call(pair.ours.get(), In(milliseconds(-1)));
  EXPECT_EQ(PollForReading(other.ours.get(), 1), 0);
  std::thread([&] { EXPECT_EQ(PollForReading(pair.ours.get(), 1), 0); }).join();
  EXPECT_FALSE(call.expired());
}

TEST_F(PahoSockets, LooksAtTheFirstByteOfTheAnswer) {
  for (const char first : {'\x20', 'S'}) {
    const Pair pair;
    PahoCall call(pair.ours.get(), Soon());
    call.ExpectFirst("\x20");
    ASSERT_EQ(send(pair.theirs.get(), &first, 1, 0), 1);
    EXPECT_EQ(PollForReading(pair.ours.get(), 100), 1);
    EXPECT_EQ(call.wrong_first().has_value(), first == 'S');
  }
}

TEST_F(PahoSockets, ProbesOnce) {
  const Pair pair;
  PahoCall call(pair.ours.get(), Soon());
  call.Probe();
  EXPECT_EQ(PollForReading(pair.ours.get(), 0), 1);
  EXPECT_EQ(PollForReading(pair.ours.get(), 0), 0);
  EXPECT_FALSE(call.readable());
}

TEST_F(PahoSockets, WritesEverythingEvenWhenTheReaderIsSlow) {
  const Pair pair;
  const std::string large(4 << 20, 'x');
  std::size_t arrived = 0;
  std::thread reader([&] {
    while (arrived < large.size() + 3) {
      static_cast<void>(WaitFor(pair.theirs.get(), POLLIN, Soon()));
      arrived += fleetpub::testing::ReadSome(pair.theirs.get()).size();
    }
  });
  const PahoCall call(pair.ours.get(), Soon());
  EXPECT_EQ(WriteTwo(pair.ours.get(), "abc", large), static_cast<ssize_t>(large.size() + 3));
  reader.join();
}

TEST_F(PahoSockets, StopsWritingAtTheDeadline) {
  const Pair pair;
  const PahoCall call(pair.ours.get(), In(milliseconds(30)));
  EXPECT_EQ(WriteTwo(pair.ours.get(), "abc", std::string(64 << 20, 'x')), -1);
  EXPECT_TRUE(call.expired());
}

}  // namespace
}  // namespace fleetpub::mqtt
