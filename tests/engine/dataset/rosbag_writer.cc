// SPDX-License-Identifier: Apache-2.0
// Writes a bag with ROS's own library, and prints what that library reads of a bag:
//   rosbag_writer write none|bz2|lz4 FILE      rosbag_writer list FILE

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/Imu.h>

namespace {

void Write(const std::string& compression, const std::string& file) {
  rosbag::Bag bag(file, rosbag::bagmode::Write);
  bag.setCompression(compression == "bz2"   ? rosbag::compression::BZ2
                     : compression == "lz4" ? rosbag::compression::LZ4
                                            : rosbag::compression::Uncompressed);
  bag.setChunkThreshold(20000);  // several chunks
  for (int i = 0; i < 5; ++i) {
    const ros::Time time(1500000000, 100000000u * i + 1);
    sensor_msgs::Image image;
    image.header.stamp = time;
    image.header.frame_id = "cam";
    image.width = 64;
    image.height = 48;
    image.encoding = "mono8";
    image.step = 64;
    for (int p = 0; p < 64 * 48; ++p)
      image.data.push_back(static_cast<unsigned char>(p / 64 + 40 * i));
    bag.write("/cam/image_raw", time, image);
    sensor_msgs::CameraInfo info;
    info.header = image.header;
    info.width = 64;
    info.height = 48;
    info.K = {60, 0, 31.5, 0, 61, 23.5, 0, 0, 1};
    info.distortion_model = "plumb_bob";
    info.D = {0, 0, 0, 0, 0};
    bag.write("/cam/camera_info", time, info);
    for (int k = 0; k < 20; ++k) {
      sensor_msgs::Imu imu;
      imu.header.stamp = time + ros::Duration(0.005 * k);
      imu.angular_velocity.x = 0.01 * i;
      imu.angular_velocity.z = 0.001 * k;
      imu.linear_acceleration.z = 9.81;
      bag.write("/imu", imu.header.stamp, imu);
    }
  }
}

void List(const std::string& file) {
  rosbag::Bag bag(file, rosbag::bagmode::Read);
  rosbag::View view(bag);
  for (const rosbag::MessageInstance& message : view) {
    std::vector<std::uint8_t> bytes(message.size());
    ros::serialization::OStream stream(bytes.data(), static_cast<std::uint32_t>(bytes.size()));
    message.write(stream);
    std::uint32_t sum = 0;
    for (const std::uint8_t byte : bytes) sum = 31 * sum + byte;
    std::printf("%lld %s %s %zu %u\n", static_cast<long long>(message.getTime().toNSec()),
                message.getTopic().c_str(), message.getDataType().c_str(), bytes.size(), sum);
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 4 && std::string(argv[1]) == "write") Write(argv[2], argv[3]);
    if (argc == 3 && std::string(argv[1]) == "list") List(argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
