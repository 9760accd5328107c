#include "interrupt.h"

#include <csignal>

namespace livemvs::app {
namespace {

volatile std::sig_atomic_t interruptions = 0;

void OnSignal(int signal) {
  interruptions = interruptions + 1;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  std::signal(SIGHUP, OnSignal);
  std::signal(SIGPIPE, SIG_IGN);  // a reader of our messages that goes away must not cost the cloud
  std::signal(SIGXFSZ, SIG_IGN);  // nor may a file that may not grow: the write then fails
}

bool Interrupted() { return interruptions != 0; }

int Interruptions() { return interruptions; }

}  // namespace livemvs::app
