#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""`plumbline record` with sequences that are played again, a serial port, UDP and standard input."""
import fcntl
import itertools
import json
import os
import pty
import signal
import socket
import struct
import subprocess
import sys
import termios
import threading
import time
import tty
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
from recorded_film import PLUMBLINE, RecordedFilm, rows  # noqa: E402


def steps(table):
    return [float(b[0]) - float(a[0]) for a, b in zip(table, table[1:])]


class RecordVerb(RecordedFilm):
    def record(self, name, *more, **options):
        out = os.path.join(self.folder.name, name)
        result = os.path.join(self.folder.name, name + ".json")
        words = [PLUMBLINE, "record", "--calibration", self.film, "--out", out, "--json", result, *more]
        options.setdefault("stderr", subprocess.DEVNULL)
        return out, result, subprocess.Popen(words, stdout=subprocess.DEVNULL, **options)

    def result(self, file):
        with open(file) as text:
            return json.load(text)

    def test_plays_a_sequence_again_and_records_it(self):
        out, result, process = self.record("again", "--camera", "play:" + self.film, "--imu", "play:" + self.film)
        self.assertEqual(process.wait(), 0)
        told = self.result(result)
        self.assertEqual((told["images"], told["gaps"], told["not_understood"]), (12, 0, 0))
        images, readings = rows(os.path.join(out, "color.csv")), rows(os.path.join(out, "imu.csv"))
        for step in steps(images):
            self.assertAlmostEqual(step, 0.1, delta=1e-6)
        were = rows(os.path.join(self.film, "imu.csv"))
        self.assertEqual(len(readings), len(were))
        for was, now, step_was, step_now in zip(were, readings, steps(were), steps(readings)):
            self.assertAlmostEqual(step_was, step_now, delta=1e-7)
            for a, b in zip(map(float, was[1:]), map(float, now[1:])):
                self.assertAlmostEqual(a, b, delta=1e-8 * max(1, abs(a)))
        # Images and readings are as far apart as they were.
        self.assertAlmostEqual(float(images[0][0]) - float(readings[0][0]), -float(were[0][0]), delta=1e-6)
        self.assertEqual(self.frames(out), 12)
        self.assertFalse(os.path.exists(os.path.join(out, "color.csv.lock")))

    def test_is_whole_when_it_is_killed(self):
        out, _, process = self.record("killed", "--camera", "play:" + self.film, "--imu", "play:" + self.film)
        self.wait_for_images(out, 4)
        process.send_signal(signal.SIGKILL)
        process.wait()
        self.assertGreaterEqual(self.frames(out), 4)

    def send(self, write, out, process):
        """150 readings of an IMU whose clock began at 1000 s, and two lines that are none."""
        self.wait_for_images(out, 1)
        write(b"hello\n")
        for i in range(150):
            write(b"%.3f,1,2,3,4,5,%d\n" % (1000 + 0.005 * i, i))
            time.sleep(0.002)
        write(b"1,2,3\n")
        process.wait()

    def check_sent(self, out, result):
        told = self.result(result)
        self.assertEqual((told["readings"], told["not_understood"], told["not_later"]), (150, 2, 0))
        readings = rows(os.path.join(out, "imu.csv"))
        for step in steps(readings):
            self.assertAlmostEqual(step, 0.005, delta=1e-7)
        images = rows(os.path.join(out, "color.csv"))
        # On the camera's clock: the first came after the first image.
        self.assertLess(abs(float(readings[0][0]) - float(images[0][0])), 5)
        self.assertEqual(float(readings[149][6]), 149)

    def test_reads_a_serial_port(self):
        ours, theirs = pty.openpty()
        tty.setraw(ours)
        out, result, process = self.record("serial", "--camera", "play:" + self.film, "--imu",
                                           "serial:" + os.ttyname(theirs), "--seconds", "5")
        self.send(lambda line: os.write(ours, line), out, process)
        self.check_sent(out, result)
        os.close(ours)
        os.close(theirs)

    def test_reads_datagrams(self):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        out, result, process = self.record("udp", "--camera", "play:" + self.film, "--imu", f"udp:{port}", "--seconds", "5")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
            self.send(lambda line: sender.sendto(line, ("127.0.0.1", port)), out, process)
        self.check_sent(out, result)

    def test_reads_a_connection_and_connects_again(self):
        listener = socket.create_server(("127.0.0.1", 0))
        out, result, process = self.record("tcp", "--camera", "play:" + self.film, "--imu",
                                           f"tcp:127.0.0.1:{listener.getsockname()[1]}", "--seconds", "6")
        sender, _ = listener.accept()
        for i in range(120):
            sender.sendall(b"%.3f,1,2,3,4,5,%d\n" % (1000 + 0.005 * i, i))
            time.sleep(0.002)
        sender.close()
        # Back after a while, and its clock begins anew.
        sender, _ = listener.accept()
        for i in range(120):
            sender.sendall(b"%.3f,1,2,3,4,5,%d\n" % (5 + 0.005 * i, 200 + i))
            time.sleep(0.002)
        self.assertEqual(process.wait(), 0)
        sender.close()
        listener.close()
        told = self.result(result)
        self.assertEqual((told["readings"], told["not_understood"], told["not_later"]), (240, 0, 0))
        readings = rows(os.path.join(out, "imu.csv"))
        between = float(readings[120][0]) - float(readings[119][0])
        self.assertGreater(between, 0.2, "the time for which it was gone")
        self.assertLess(between, 4)
        self.assertEqual(float(readings[239][6]), 319)

    def test_reads_a_stream_that_breaks_off_and_is_back(self):
        folder = os.path.join(self.film, "color")
        pictures = []
        for name in sorted(os.listdir(folder)):
            with open(os.path.join(folder, name), "rb") as file:
                pictures.append(file.read())
        listener = socket.create_server(("127.0.0.1", 0))
        on = threading.Event()
        on.set()

        def show(viewer):
            try:
                viewer.recv(4096)
                viewer.sendall(b"HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=image\r\n\r\n")
                for i in itertools.count():
                    if not on.is_set():
                        return
                    picture = pictures[i % len(pictures)]
                    viewer.sendall(b"--image\r\nContent-Type: image/jpeg\r\nContent-Length: %d\r\n\r\n" % len(picture) + picture + b"\r\n")
                    time.sleep(0.02)
            except OSError:  # nobody looks any more
                pass
            finally:
                viewer.close()

        def serve():
            while True:
                try:
                    viewer, _ = listener.accept()
                except OSError:  # the end of this test
                    return
                threading.Thread(target=show, args=(viewer,), daemon=True).start()

        threading.Thread(target=serve, daemon=True).start()
        out, _, process = self.record("stream", "--camera", f"http://127.0.0.1:{listener.getsockname()[1]}/video.mjpg",
                                      "--imu", "play:" + self.film)
        self.wait_for_images(out, 10)
        on.clear()
        time.sleep(2.5)
        before = len(rows(os.path.join(out, "color.csv")))
        on.set()
        self.wait_for_images(out, before + 10)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(), 0)
        listener.close()
        self.assertGreater(max(steps(rows(os.path.join(out, "color.csv")))), 2, "the time for which it was gone")
        self.assertGreaterEqual(self.frames(out), before + 10)

    def wait_until_read(self, port):
        """Until nobody has left anything unread in a terminal for a while: what is unread when it is closed is lost."""
        empty_since = None
        deadline = time.monotonic() + 30
        while empty_since is None or time.monotonic() < empty_since + 0.3:
            self.assertLess(time.monotonic(), deadline, "nobody reads the port")
            unread = struct.unpack("i", fcntl.ioctl(port, termios.FIONREAD, struct.pack("i", 0)))[0]
            if unread > 0:
                empty_since = None
            elif empty_since is None:
                empty_since = time.monotonic()
            time.sleep(0.02)

    def test_reads_a_serial_port_that_is_unplugged_and_back(self):
        port = os.path.join(self.folder.name, "port")
        ours, theirs = pty.openpty()
        tty.setraw(ours)
        os.symlink(os.ttyname(theirs), port)
        out, result, process = self.record("unplugged", "--camera", "play:" + self.film, "--imu", "serial:" + port,
                                           "--seconds", "6")
        self.wait_for_images(out, 1)
        for i in range(120):
            os.write(ours, b"%.3f,1,2,3,4,5,%d\n" % (1000 + 0.005 * i, i))
            time.sleep(0.002)
        began = time.monotonic()
        self.wait_until_read(theirs)
        os.close(ours)
        os.close(theirs)
        ours, theirs = pty.openpty()
        tty.setraw(ours)
        os.remove(port)
        os.symlink(os.ttyname(theirs), port)
        # What it sends before anybody listens is lost, or comes late.
        while time.monotonic() < began + 3:
            time.sleep(0.05)
        for i in range(50):
            os.write(ours, b"%.3f,1,2,3,4,5,%d\n" % (1000.6 + time.monotonic() - began, 900 + i))
            time.sleep(0.005)
        self.assertEqual(process.wait(), 0)
        readings = rows(os.path.join(out, "imu.csv"))
        self.assertEqual(len(readings), 170)
        self.assertEqual(self.result(result)["not_later"], 0)
        # The same clock: the gap is as long as it was.
        self.assertAlmostEqual(float(readings[120][0]) - float(readings[119][0]), 3.0, delta=0.1)
        os.close(ours)
        os.close(theirs)

    def test_reads_standard_input(self):
        out, result, process = self.record("stdin", "--camera", "play:" + self.film, "--imu", "-", "--seconds", "5",
                                           stdin=subprocess.PIPE)

        def write(line):
            process.stdin.write(line)
            process.stdin.flush()

        self.send(write, out, process)
        process.stdin.close()
        self.check_sent(out, result)

    def test_keeps_the_readings_of_an_imu_that_gave_few(self):
        out, result, process = self.record("few", "--camera", "play:" + self.film, "--imu", "-", stdin=subprocess.PIPE)
        process.stdin.write(b"".join(b"%.1f,1,2,3,4,5,6\n" % (1000 + 0.1 * i) for i in range(7)))
        process.stdin.close()
        self.assertEqual(process.wait(), 0)
        self.assertEqual(self.result(result)["readings"], 7)
        for step in steps(rows(os.path.join(out, "imu.csv"))):
            self.assertAlmostEqual(step, 0.1, delta=1e-7)

    def refusal(self, *more):
        out, _, process = self.record("refused" + str(time.monotonic_ns()), *more, stderr=subprocess.PIPE, text=True)
        text = process.communicate()[1]
        self.assertNotEqual(process.returncode, 0)
        if "play:" + self.film not in more:
            self.assertFalse(os.path.exists(out), "nothing came")
        return text

    def test_refuses_in_one_sentence(self):
        self.assertIn("there is no camera '/dev/video77'", self.refusal("--camera", "77"))
        self.assertIn("is no camera, video or stream", self.refusal("--camera", "/nowhere.mp4"))
        self.assertIn("is no IMU: write serial", self.refusal("--camera", "play:" + self.film, "--imu", "bluetooth"))
        self.assertIn("is no serial port", self.refusal("--camera", "play:" + self.film, "--imu", "serial:/dev/nothing"))
        self.assertIn("names no port", self.refusal("--camera", "play:" + self.film, "--imu", "udp:0"))
        self.assertIn("is not tcp:HOST:PORT", self.refusal("--camera", "play:" + self.film, "--imu", "tcp:1234"))
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.assertIn("nobody listens at", self.refusal("--camera", "play:" + self.film, "--imu", f"tcp:127.0.0.1:{port}"))
        self.assertIn("is no exposure", self.refusal("--camera", "play:" + self.film, "--exposure", "dark"))
        out, _, process = self.record("film", "--camera", "play:" + self.film, stderr=subprocess.PIPE, text=True)
        self.assertIn("is there already", process.communicate()[1])


if __name__ == "__main__":
    unittest.main()
