// SPDX-License-Identifier: Apache-2.0
// Alternative frame encodings: raw drivers and kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <thread>

#include "server/session/rpc/grpc_server_fixture.h"
#include "skin/skin_kernels.h"
#include "wire/frame_stream.h"
#include "wire/kernel_codec.h"

namespace livegs {
namespace {

template <class Vector>
std::vector<float> floats_of(const std::vector<Vector>& vectors) {
  std::vector<float> floats;
  for (const Vector& vector : vectors) {
    for (int i = 0; i < static_cast<int>(std::size(vector)); ++i) floats.push_back(vector[i]);
  }
  return floats;
}

std::vector<float> floats_of(const std::vector<Eigen::Quaternionf>& turns) {
  std::vector<float> floats;
  for (const Eigen::Quaternionf& turn : turns)
    floats.insert(floats.end(), turn.coeffs().begin(), turn.coeffs().end());
  return floats;
}

PosedKernels posed(const SceneObject& object, const ObjectDrivers& drivers) {
  const auto bindings = bind_kernels(*object.asset, object.rest);
  EXPECT_TRUE(bindings) << bindings.error().message;
  PosedKernels kernels;
  skin_kernels(*object.asset, object.rest, *bindings, drivers, kernels);
  return kernels;
}

class Encodings : public GrpcServerTest {
 protected:
  std::unique_ptr<RawClient> client(v1::JoinRequest::Encoding encoding) {
    auto made = std::make_unique<RawClient>(server_->port());
    made->encoding = encoding;
    EXPECT_TRUE(made->join().ok());
    EXPECT_EQ(made->joined.encoding(), encoding);
    made->open();
    return made;
  }
  // The server poses kernels only after the streams are attached.
  void wait_streaming(size_t count) {
    for (int i = 0; i < 2000 && server_->streaming_count() < count; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_EQ(server_->streaming_count(), count);
  }
};

TEST_F(Encodings, RawDriversAreBitExact) {
  open();
  const auto raw = client(v1::JoinRequest::DRIVERS_RAW);
  for (uint64_t number = 1; number <= 3; ++number) {
    scene_.step();
    server_->ticks().publish(tick(number));
    const v1::ServerMessage message = raw->read();
    ASSERT_EQ(message.tick(), number);
    const auto frame = decode_frame(std::as_bytes(std::span(message.frame())));
    ASSERT_TRUE(frame) << frame.error().message;
    const DriverFrame own = scene_.world().drivers();
    ASSERT_EQ(frame->objects.size(), own.objects.size());
    for (size_t i = 0; i < own.objects.size(); ++i) {
      EXPECT_EQ(floats_of(frame->objects[i].positions_m), floats_of(own.objects[i].positions_m));
      ASSERT_EQ(frame->objects[i].poses.size(), own.objects[i].poses.size());
      for (size_t p = 0; p < own.objects[i].poses.size(); ++p)
        EXPECT_EQ(frame->objects[i].poses[p].position_m.cast<float>(),
                  own.objects[i].poses[p].position_m.cast<float>());
    }
    ASSERT_TRUE(raw->acknowledge(number));
  }
  EXPECT_TRUE(raw->finish().ok());
}

// Two clients with kernel encodings and one with drivers get the same ticks. Kernels match the drivers, exact
// ones bit by bit, and include a new ball.
TEST_F(Encodings, KernelsMatchTheDrivers) {
  open();
  const auto packed = client(v1::JoinRequest::KERNELS), exact = client(v1::JoinRequest::KERNELS_EXACT),
             drivers = client(v1::JoinRequest::DRIVERS);
  wait_streaming(3);
  StreamReader reader;
  for (uint64_t number = 1; number <= 4; ++number) {
    scene_.step();
    TickResult stepped = tick(number);
    if (number == 3) {
      stepped.added.push_back(shoot());
      stepped.drivers = scene_.world().drivers();
      stepped.drivers.tick = number;
    }
    const DriverFrame own = stepped.drivers;
    server_->ticks().publish(std::move(stepped));
    const v1::ServerMessage streamed = drivers->read();
    ASSERT_EQ(streamed.tick(), number);
    ASSERT_TRUE(reader.read(std::as_bytes(std::span(streamed.frame()))));
    ASSERT_TRUE(drivers->acknowledge(number));
    for (RawClient* one : {packed.get(), exact.get()}) {
      v1::ServerMessage message;
      int events = 0;
      do {  // events do not wait for kernels
        message = one->read();
        events += message.events_size();
      } while (message.frame().empty() && message.events_size() > 0);
      EXPECT_EQ(events, number == 3 ? 1 : 0);
      ASSERT_EQ(message.tick(), number);
      const auto frame = decode_kernels(std::as_bytes(std::span(message.frame())));
      ASSERT_TRUE(frame) << frame.error().message;
      EXPECT_EQ(frame->tick, number);
      ASSERT_EQ(frame->objects.size(), own.objects.size());
      for (size_t i = 0; i < own.objects.size(); ++i) {
        const SceneObject* object = scene_.find(frame->objects[i].object_id);
        ASSERT_NE(object, nullptr);
        const PosedKernels expected = posed(*object, own.objects[i]);
        const PosedKernels& is = frame->objects[i].kernels;
        ASSERT_EQ(is.positions_m.size(), object->asset->size());
        if (one == exact.get()) {
          EXPECT_EQ(floats_of(is.positions_m), floats_of(expected.positions_m));
          EXPECT_EQ(floats_of(is.covariances_m2), floats_of(expected.covariances_m2));
          EXPECT_EQ(floats_of(is.world_from_asset), floats_of(expected.world_from_asset));
        } else {
          float off_m = 0;
          Eigen::AlignedBox3f box;
          for (size_t k = 0; k < is.positions_m.size(); ++k) {
            off_m = std::max(off_m, (is.positions_m[k] - expected.positions_m[k]).cwiseAbs().maxCoeff());
            box.extend(expected.positions_m[k]);
          }
          EXPECT_LT(off_m, 0.5f / 65535 * box.sizes().maxCoeff() +
                               2e-7f);  // half a step plus float rounding at half a metre
        }
      }
      ASSERT_TRUE(one->acknowledge(number));
    }
  }
  for (RawClient* one : {packed.get(), exact.get(), drivers.get()}) EXPECT_TRUE(one->finish().ok());
}

// A session may resume with another encoding; earlier offers are not sent.
TEST_F(Encodings, ResumedSessionMayChangeItsEncoding) {
  open();
  const auto one = client(v1::JoinRequest::DRIVERS);
  publish(1);
  ASSERT_EQ(one->read().tick(), 1u);
  const std::string id = one->joined.session_id();
  one->cancel();
  (void)one->finish_reading();
  one->encoding = v1::JoinRequest::KERNELS;
  ASSERT_TRUE(one->join(kProtocolVersion, id).ok());
  publish(2);
  while (server_->session_table().status().tick < 2)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  one->open();
  wait_streaming(1);
  publish(3);
  const v1::ServerMessage message = one->read();
  EXPECT_EQ(message.tick(), 3u);
  EXPECT_TRUE(decode_kernels(std::as_bytes(std::span(message.frame()))));
  EXPECT_TRUE(one->finish().ok());
}

TEST_F(Encodings, RefusesUnknownEncodingsByField) {
  open();
  RawClient client(server_->port());
  client.encoding = static_cast<v1::JoinRequest::Encoding>(4);
  const grpc::Status status = client.join();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_EQ(status.error_message().rfind("encoding: ", 0), 0u) << status.error_message();
}

// A frame has a size limit; a scene whose kernels exceed it is refused at Join.
TEST_F(Encodings, RefusesMoreKernelsThanAFrameHolds) {
  const SceneObject& box = *scene_.find("box");
  ASSERT_EQ(box.asset->size(), 6000u);
  server_->open("many", 90, std::vector<const SceneObject*>(250, &box), inputs_);
  RawClient client(server_->port());
  client.encoding = v1::JoinRequest::KERNELS_EXACT;
  const grpc::Status status = client.join();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::INVALID_ARGUMENT);
  EXPECT_NE(status.error_message().find("1500000 kernels take 74 MiB"), std::string::npos)
      << status.error_message();
  client.encoding = v1::JoinRequest::KERNELS;
  EXPECT_TRUE(client.join().ok());
}

}  // namespace
}  // namespace livegs
