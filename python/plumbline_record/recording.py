# SPDX-License-Identifier: Apache-2.0
"""A recording in Plumbline's own layout, written while it is made: for cameras and IMUs that Plumbline has no driver for.

    with Recording("walk", "camera.json", "imu.json") as recording:
        recording.readings([(stamp_s, wx, wy, wz, ax, ay, az), ..])  # rad/s, m/s^2, as they come
        recording.image(stamp_s, jpeg_bytes)

Meanwhile `plumbline run walk --live --poses vio` maps it. Stamps are seconds; of both, and of one clock but for the
`time_offset_s` of imu.json. What is written survives however this process ends (docs/networks.md, "While it is recorded").
"""
import fcntl
import os
import shutil


class Recording:
    def __init__(self, folder, camera_json, imu_json=None):
        """Makes the folder, which must not be there or be empty. camera_json needs `body_from_cam`; docs/formats.md."""
        os.makedirs(os.path.join(folder, "color"), exist_ok=True)
        if os.listdir(folder) != ["color"] or os.listdir(os.path.join(folder, "color")):
            raise FileExistsError(f"'{folder}' is not empty; a recording needs a new folder")
        self.folder = folder
        self._lock = open(os.path.join(folder, "color.csv.lock"), "w")
        fcntl.flock(self._lock, fcntl.LOCK_EX)  # "this is being written"; the system lets go of it
        shutil.copy(camera_json, os.path.join(folder, "camera.json"))
        if imu_json:
            shutil.copy(imu_json, os.path.join(folder, "imu.json"))
        self._imu = self._table("imu.csv", "t,wx,wy,wz,ax,ay,az\n")
        self._images = self._table("color.csv", "stamp_s,file\n")
        self.num_images = 0

    def _table(self, name, heading):
        table = os.open(os.path.join(self.folder, name), os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
        os.write(table, heading.encode())
        return table

    def readings(self, rows):
        """Rows of (stamp_s, wx, wy, wz [rad/s], ax, ay, az [m/s^2]) in the axes of the body, biases included."""
        os.write(self._imu, "".join("%.9f,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n" % tuple(row) for row in rows).encode())

    def image(self, stamp_s, encoded, ending=".jpg"):
        """An encoded image (JPEG, or PNG with its ending), after the readings up to its time as far as they have come."""
        name = f"{self.num_images:06d}{ending}"
        place = os.path.join(self.folder, "color", name)
        with open(place + ".part", "wb") as file:
            file.write(encoded)
        os.rename(place + ".part", place)  # the image is whole before its row is there
        os.write(self._images, b"%.9f,color/%s\n" % (stamp_s, name.encode()))
        self.num_images += 1

    def close(self):
        os.close(self._imu)
        os.close(self._images)
        os.unlink(self._lock.name)
        self._lock.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
