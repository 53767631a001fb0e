// A client as the vendor ships it for C++: reads calls, one on a line, and writes the answers.
//
//     driver <host> <port>
//     driver serve simple|threaded|pool
//
// The second serves calls as a controller may: by the server of that name, with the processor that
// the same compiler generated. It writes its port, and ends with its input.
//
// A line is "<service> <function> <arguments>", the arguments being the generated struct of them
// in Thrift's JSON. An answer is one line of JSON: {"answer": <the generated result struct>},
// {"refused": "<text>"} for an application error, or {"lost": "<text>"}, after which the next call
// opens a new connection.

#include <atomic>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <thrift/TApplicationException.h>
#include <thrift/protocol/TBinaryProtocol.h>
#include <thrift/concurrency/ThreadFactory.h>
#include <thrift/concurrency/ThreadManager.h>
#include <thrift/protocol/TJSONProtocol.h>
#include <thrift/server/TSimpleServer.h>
#include <thrift/server/TThreadPoolServer.h>
#include <thrift/server/TThreadedServer.h>
#include <thrift/transport/TBufferTransports.h>
#include <thrift/transport/TServerSocket.h>
#include <thrift/transport/TSocket.h>

#include "First.h"
#include "Older.h"
#include "Oldest.h"
#include "RPCRobot.h"
#include "Short.h"

namespace {

using apache::thrift::TApplicationException;
using apache::thrift::TException;
using apache::thrift::protocol::TBinaryProtocol;
using apache::thrift::protocol::TBinaryProtocolFactory;
using apache::thrift::protocol::TJSONProtocol;
using apache::thrift::protocol::TProtocol;
using apache::thrift::transport::TBufferedTransport;
using apache::thrift::transport::TBufferedTransportFactory;
using apache::thrift::transport::TMemoryBuffer;
using apache::thrift::transport::TServerSocket;
using apache::thrift::transport::TSocket;

using Call = std::function<void(TProtocol&, TProtocol&)>;
using Calls = std::map<std::string, Call>;

// The generated clients of all services on one connection.
struct Robot {
  explicit Robot(const std::shared_ptr<TProtocol>& wire)
      : full(wire), brief(wire), older(wire), oldest(wire), first(wire) {}
  RPCRobotClient full;
  clients::ShortClient brief;
  clients::OlderClient older;
  clients::OldestClient oldest;
  clients::FirstClient first;
};

template <class Args>
Args read(TProtocol& json) {
  Args args;
  args.read(&json);
  return args;
}

Calls calls(Robot& robot) {
  return {
#include "calls.inc"
  };
}

std::string quoted(const std::string& text) {
  std::ostringstream out;
  out << '"';
  for (unsigned char c : text) {
    if (c == '"' || c == '\\') {
      out << '\\' << c;
    } else {
      out << (c < ' ' ? ' ' : static_cast<char>(c));
    }
  }
  out << '"';
  return out.str();
}

class Driver {
 public:
  Driver(std::string host, int port) : host_(std::move(host)), port_(port) {}

  std::string answer(const std::string& call, const std::string& args) {
    try {
      open();
      auto in = std::make_shared<TMemoryBuffer>(
          reinterpret_cast<uint8_t*>(const_cast<char*>(args.data())),
          static_cast<uint32_t>(args.size()));
      auto out = std::make_shared<TMemoryBuffer>();
      TJSONProtocol reader(in);
      TJSONProtocol writer(out);
      calls_.at(call)(reader, writer);
      return "{\"answer\": " + out->getBufferAsString() + "}";
    } catch (const TApplicationException& error) {
      return "{\"refused\": " + quoted(error.what()) + "}";
    } catch (const TException& error) {
      calls_.clear();
      robot_.reset();
      return "{\"lost\": " + quoted(error.what()) + "}";
    }
  }

 private:
  void open() {
    if (robot_) return;
    auto socket = std::make_shared<TSocket>(host_, port_);
    socket->setRecvTimeout(20000);
    auto transport = std::make_shared<TBufferedTransport>(socket);
    transport->open();
    robot_ = std::make_unique<Robot>(std::make_shared<TBinaryProtocol>(transport));
    calls_ = calls(*robot_);
  }

  std::string host_;
  int port_;
  std::unique_ptr<Robot> robot_;
  Calls calls_;
};

// Answers with how many calls came before, so that one can tell an answer from the next.
class Counting : public RPCRobotNull {
 public:
  void get_robot_state(std::vector<int8_t>& _return) override { _return = {6, 0, 5, next()}; }

  void getRobotStatus(RobotStatus& _return) override {
    _return.jointActualPosition.assign(6, next());
  }

  void get_tcp_force(std::vector<double>& _return) override { _return.assign(6, next()); }

  void get_ext_torque(std::vector<double>& _return) override {
    next();
    throw std::runtime_error("not here");
  }

 private:
  int8_t next() { return static_cast<int8_t>(calls_++ % 100); }

  std::atomic<int> calls_{0};
};

// Writes the port once the server listens.
class Port : public apache::thrift::server::TServerEventHandler {
 public:
  explicit Port(std::shared_ptr<TServerSocket> socket) : socket_(std::move(socket)) {}
  void preServe() override { std::cout << socket_->getPort() << std::endl; }

 private:
  std::shared_ptr<TServerSocket> socket_;
};

int serve(const std::string& kind) {
  using apache::thrift::concurrency::ThreadFactory;
  using apache::thrift::concurrency::ThreadManager;
  using namespace apache::thrift::server;
  auto processor = std::make_shared<RPCRobotProcessor>(std::make_shared<Counting>());
  auto socket = std::make_shared<TServerSocket>("127.0.0.1", 0);
  auto transports = std::make_shared<TBufferedTransportFactory>();
  auto protocols = std::make_shared<TBinaryProtocolFactory>();
  std::shared_ptr<TServer> server;
  if (kind == "simple") {
    server = std::make_shared<TSimpleServer>(processor, socket, transports, protocols);
  } else if (kind == "threaded") {
    server = std::make_shared<TThreadedServer>(processor, socket, transports, protocols);
  } else {
    auto threads = ThreadManager::newSimpleThreadManager(4);
    threads->threadFactory(std::make_shared<ThreadFactory>());
    threads->start();
    server =
        std::make_shared<TThreadPoolServer>(processor, socket, transports, protocols, threads);
  }
  server->setServerEventHandler(std::make_shared<Port>(socket));
  std::thread serving([&server] { server->serve(); });
  std::cin.ignore(std::numeric_limits<std::streamsize>::max());
  std::_Exit(0);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: driver <host> <port>, or driver serve simple|threaded|pool\n";
    return 2;
  }
  apache::thrift::GlobalOutput.setOutputFunction([](const char*) {});
  if (std::string(argv[1]) == "serve") return serve(argv[2]);
  Driver driver(argv[1], std::stoi(argv[2]));
  std::string service;
  std::string function;
  std::string args;
  while (std::cin >> service >> function >> std::ws && std::getline(std::cin, args)) {
    std::cout << driver.answer(service + " " + function, args) << std::endl;
  }
  return 0;
}
