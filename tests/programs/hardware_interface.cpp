// A hardware interface in the manner of ROS 2 drivers: activate, then read and write 250 times a
// second, with a heartbeat on a thread and a connection of its own.
//
//     hardware_interface <host> <port>
//
// Says at its end where the first joint was to be, and where it is.

#include <atomic>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <thrift/protocol/TBinaryProtocol.h>
#include <thrift/transport/TBufferTransports.h>
#include <thrift/transport/TSocket.h>

#include "RPCRobot.h"

using apache::thrift::protocol::TBinaryProtocol;
using apache::thrift::transport::TBufferedTransport;
using apache::thrift::transport::TSocket;
using Clock = std::chrono::steady_clock;

class Connection {
 public:
  Connection(const std::string& host, int port)
      : transport_(std::make_shared<TBufferedTransport>(std::make_shared<TSocket>(host, port))),
        robot(std::make_shared<TBinaryProtocol>(transport_)) {
    transport_->open();
  }

 private:
  std::shared_ptr<TBufferedTransport> transport_;

 public:
  RPCRobotClient robot;
};

class Hardware {
 public:
  Hardware(const std::string& host, int port)
      : main_(host, port), beats_(host, port), heart_([this] { beat(); }) {}

  ~Hardware() {
    running_ = false;
    heart_.join();
  }

  bool activate() {
    return main_.robot.power_on(true) == 4 && main_.robot.enable(true) == 4;
  }

  std::vector<double> read() {
    RobotStatus status;
    main_.robot.getRobotStatus(status);
    return status.jointActualPosition;
  }

  bool write(const std::vector<double>& joints) {
    return main_.robot.servoj(joints, 3.5, 3.5, false, 400, 80, 5, 2) >= 1000;
  }

  bool moving() { return main_.robot.robotmoving(); }

  bool deactivate() { return main_.robot.stop(true) == 4; }

 private:
  void beat() {
    while (running_) {
      beats_.robot.rpc_heartbeat(1000);
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }

  Connection main_;
  Connection beats_;
  std::atomic<bool> running_{true};
  std::thread heart_;
};

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Hardware hardware(argv[1], std::stoi(argv[2]));
  if (!hardware.activate()) return 3;
  const std::vector<double> start = hardware.read();
  std::vector<double> goal = start;
  auto next = Clock::now();
  for (int cycle = 1; cycle <= 250; ++cycle) {
    hardware.read();
    goal[0] = start[0] + 0.15 * (1 - std::cos(3.141592653589793 * cycle / 250));
    if (!hardware.write(goal)) return 4;
    next += std::chrono::milliseconds(4);
    std::this_thread::sleep_until(next);
  }
  while (hardware.moving()) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  std::cout << goal[0] << " " << hardware.read()[0] << std::endl;
  return hardware.deactivate() ? 0 : 5;
}
