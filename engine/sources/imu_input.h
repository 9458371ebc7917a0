// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/result.h"
#include "engine/sources/imu_lines.h"
#include "engine/sources/sensor_work.h"

namespace plumbline {

/// Reads lines of an IMU. What is unplugged (a serial port, a connection) is opened again until it
/// is back.
/// @param spec  serial:DEVICE[@BAUD], udp:PORT (of this machine), tcp:HOST:PORT (who listens
/// there), - (standard input), or play:SEQUENCE, whose stamps are on this machine's clock.
/// @param line  Nothing for one that is not understood. Errors: kInvalidInput, kNotFound, kIo;
/// those of the sequence; what `line` returns.
Status ReadImuInput(
    const std::string& spec, const SensorWork& work,
    const std::function<Status(const std::optional<ImuLine>& line, std::int64_t arrived_ns)>& line);

}  // namespace plumbline
