#include "plan_client.h"

#include <chrono>
#include <iomanip>
#include <sstream>

#include <social_fleet/AddOverlay.h>
#include <social_fleet/ClearOverlay.h>

namespace social_fleet
{
namespace
{
using Clock = std::chrono::steady_clock;

bool sameCells(const std::vector<geometry_msgs::Point>& one, const std::vector<geometry_msgs::Point>& other)
{
  if (one.size() != other.size())
    return false;
  for (size_t i = 0; i < one.size(); ++i)
    if (one[i].x != other[i].x || one[i].y != other[i].y)
      return false;
  return true;
}
}  // namespace

struct PlanClient::Exchange
{
  PlanPathRequest request;
  Obstacles obstacles;
  Answer answer;
  bool done = false;
};

/** The services of one planner, connected; and which obstacles it was told of over these connections. */
struct PlanClient::Connection
{
  explicit Connection(const std::string& server)
  {
    // A namespace that callers cannot have: the name is global, or relative to the node's namespace.
    ros::NodeHandle node;
    plan_path = node.serviceClient<PlanPath>(server + "/plan_path", true);
    add_overlay = node.serviceClient<AddOverlay>(server + "/add_overlay", true);
    clear_overlay = node.serviceClient<ClearOverlay>(server + "/clear_overlay", true);
  }

  bool isValid() const
  {
    return plan_path.isValid() && add_overlay.isValid() && clear_overlay.isValid();
  }

  void cut()
  {
    plan_path.shutdown();
    add_overlay.shutdown();
    clear_overlay.shutdown();
  }

  /** Let the planner know of the obstacles as they are; returns why it does not, or nothing. */
  std::string tell(const Obstacles& obstacles)
  {
    const ros::Time now = ros::Time::now();
    const bool same = sameCells(obstacles.cells, told);
    if (same && (told.empty() || (now >= told_at && now - told_at < obstacles.lifetime * 0.5)))
      return "";
    const std::string problem = obstacles.cells.empty() ? clear(obstacles) : add(obstacles);
    if (problem.empty())
    {
      told = obstacles.cells;
      told_at = now;
    }
    return problem;
  }

  std::string add(const Obstacles& obstacles)
  {
    AddOverlay service;
    service.request.header.frame_id = obstacles.frame;
    service.request.name = obstacles.name;
    service.request.robot = obstacles.robot;
    service.request.shape = AddOverlayRequest::CELLS;
    service.request.pose.orientation.w = 1.0;
    service.request.points = obstacles.cells;
    service.request.lifetime = obstacles.lifetime;
    if (!add_overlay.call(service))
      return "it did not take the costmap's obstacles";
    return service.response.message;
  }

  std::string clear(const Obstacles& obstacles)
  {
    ClearOverlay service;
    service.request.name = obstacles.name;
    // That there is none of the name is fine: it may have expired.
    return clear_overlay.call(service) ? "" : "it did not clear the costmap's obstacles";
  }

  ros::ServiceClient plan_path, add_overlay, clear_overlay;
  std::vector<geometry_msgs::Point> told;
  ros::Time told_at;
};

class PlanClient::Worker
{
public:
  explicit Worker(const std::string& server) : server_(server)
  {
  }

  /** Work until `stop`; for the thread. */
  void run()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true)
    {
      changed_.wait(lock, [this] { return stopped_ || exchange_; });
      if (stopped_)
        return;
      const std::shared_ptr<Exchange> exchange = exchange_;
      lock.unlock();
      serve(*exchange);
      lock.lock();
      exchange->done = true;
      exchange_.reset();
      changed_.notify_all();
    }
  }

  /** Return once nothing is under way any more. */
  void stop()
  {
    std::unique_lock<std::mutex> lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
    // Once more and again: a call that began just after a cut has connected anew.
    do
      cut();
    while (!changed_.wait_for(lock, std::chrono::milliseconds(20), [this] { return !exchange_; }));
  }

  /** Whether the exchange took place before `deadline`; if not, its connections are cut. */
  bool perform(const std::shared_ptr<Exchange>& exchange, Clock::time_point deadline)
  {
    std::unique_lock<std::mutex> lock(mutex_);
    // An earlier call that was cut off may not have returned yet; had it just begun, it has connected anew.
    if (exchange_)
      cut();
    if (!changed_.wait_until(lock, deadline, [this] { return !exchange_; }))
      return false;
    exchange_ = exchange;
    abandoned_ = false;
    changed_.notify_all();
    if (changed_.wait_until(lock, deadline, [&exchange] { return exchange->done; }))
      return true;
    abandoned_ = true;
    cut();
    return false;
  }

private:
  /** With the mutex held. */
  void cut()
  {
    if (connection_)
      connection_->cut();
  }

  bool isAwaited()
  {
    std::lock_guard<std::mutex> lock(mutex_);
    return !stopped_ && !abandoned_;
  }

  void serve(Exchange& exchange)
  {
    // A connection of before may be one to a planner that has been started anew since: then once more.
    for (const bool fresh : { false, true })
    {
      const std::shared_ptr<Connection> connection = connect(fresh);
      if (!connection)
        continue;
      const std::string problem = connection->tell(exchange.obstacles);
      PlanPath service;
      service.request = exchange.request;
      if (isAwaited() && connection->plan_path.call(service))
      {
        exchange.answer.came = true;
        exchange.answer.response = service.response;
        exchange.answer.reason = problem;
        return;
      }
    }
    exchange.answer.reason = ros::names::resolve(server_) + " is not there or died; is the node social_planner running?";
  }

  /** A connection, new where asked for or where the last one is cut; none when that fails or nobody waits any more. */
  std::shared_ptr<Connection> connect(bool fresh)
  {
    std::shared_ptr<Connection> connection;
    {
      std::lock_guard<std::mutex> lock(mutex_);
      if (stopped_ || abandoned_)
        return nullptr;
      connection = connection_;
    }
    if (!fresh && connection && connection->isValid())
      return connection;
    connection = std::make_shared<Connection>(server_);
    std::lock_guard<std::mutex> lock(mutex_);
    if (stopped_ || abandoned_ || !connection->isValid())
      return nullptr;
    connection_ = connection;
    return connection;
  }

  const std::string server_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::shared_ptr<Exchange> exchange_;     // what is under way
  std::shared_ptr<Connection> connection_;
  bool abandoned_ = false;                 // nobody waits for the exchange any more
  bool stopped_ = false;
};

PlanClient::PlanClient(const std::string& server) : worker_(std::make_shared<Worker>(server))
{
  const std::shared_ptr<Worker> worker = worker_;
  thread_ = std::thread([worker] { worker->run(); });
}

PlanClient::~PlanClient()
{
  worker_->stop();
  thread_.join();
}

Answer PlanClient::ask(const PlanPathRequest& request, const Obstacles& obstacles, const ros::WallDuration& patience)
{
  const Clock::time_point deadline = Clock::now() + std::chrono::nanoseconds(patience.toNSec());
  std::ostringstream reason;
  reason << "no answer within " << std::setprecision(2) << patience.toSec() << " s";
  Answer nothing;
  nothing.reason = reason.str();
  std::unique_lock<std::timed_mutex> turn(one_at_a_time_, deadline);
  if (!turn.owns_lock())
    return nothing;
  const auto exchange = std::make_shared<Exchange>();
  exchange->request = request;
  exchange->obstacles = obstacles;
  return worker_->perform(exchange, deadline) ? exchange->answer : nothing;
}
}  // namespace social_fleet
