#include "social_global_planner.h"

#include <cmath>

#include <nav_msgs/Path.h>
#include <pluginlib/class_list_macros.hpp>

PLUGINLIB_EXPORT_CLASS(social_fleet::SocialGlobalPlanner, nav_core::BaseGlobalPlanner)

namespace social_fleet
{
namespace
{
constexpr double WARNING_PERIOD = 5.0;  // [s] between two warnings of the same kind

std::string withoutSlash(const std::string& frame)
{
  return frame.substr(0, 1) == "/" ? frame.substr(1) : frame;
}

/** A parameter that has to be at least `minimum`; what is less is told of and replaced. */
double atLeast(const ros::NodeHandle& node, const std::string& name, double value, double minimum)
{
  double given = value;
  node.param(name, given, value);
  if (std::isfinite(given) && given >= minimum)
    return given;
  ROS_ERROR("%s must be at least %g, not %g: %g is used", node.resolveName(name).c_str(), minimum, given, value);
  return value;
}

/** Whether the planner itself is in trouble, rather than the question. */
bool isTrouble(uint8_t status)
{
  switch (status)
  {
    case PlanPathResponse::FAILURE:
    case PlanPathResponse::PAT_EXCEEDED:
    case PlanPathResponse::NOT_INITIALIZED:
    case PlanPathResponse::INTERNAL_ERROR:
    case PlanPathResponse::MAP_ERROR:
      return true;
    default:
      return false;
  }
}
}  // namespace

SocialGlobalPlanner::~SocialGlobalPlanner()
{
  if (spinner_)
    spinner_->stop();
}

void SocialGlobalPlanner::initialize(std::string name, costmap_2d::Costmap2DROS* costmap_ros)
{
  if (costmap_ros_ != nullptr)
  {
    ROS_WARN("%s is initialized already", name_.c_str());
    return;
  }
  name_ = name;
  costmap_ros_ = costmap_ros;
  frame_ = withoutSlash(costmap_ros->getGlobalFrameID());
  readParameters();
  loadFallback();
  client_.reset(new PlanClient(parameters_.server));

  ros::NodeHandle node, own("~/" + name);
  node.setCallbackQueue(&queue_);
  own.setCallbackQueue(&queue_);
  plan_publisher_ = own.advertise<nav_msgs::Path>("plan", 1);
  if (parameters_.pass_obstacles)
    map_subscriber_ = node.subscribe("map", 1, &SocialGlobalPlanner::hearMap, this);
  make_plan_ = own.advertiseService("make_plan", &SocialGlobalPlanner::serveMakePlan, this);
  spinner_.reset(new ros::AsyncSpinner(1, &queue_));
  spinner_->start();
  ROS_INFO("%s asks %s/plan_path for paths%s%s", name.c_str(), ros::names::resolve(parameters_.server).c_str(),
           fallback_ ? ", and when that does not answer, " : "", parameters_.fallback_planner.c_str());
}

void SocialGlobalPlanner::readParameters()
{
  ros::NodeHandle own("~/" + name_);
  own.param("server", parameters_.server, std::string("social_planner"));
  own.param("robot", parameters_.robot, std::string());
  own.param("fallback_planner", parameters_.fallback_planner, std::string());
  own.param("pass_obstacles", parameters_.pass_obstacles, true);
  parameters_.planner_patience = atLeast(own, "planner_patience", 5.0, 0.01);
  parameters_.default_tolerance = atLeast(own, "default_tolerance", 0.0, 0.0);
  parameters_.start_tolerance = atLeast(own, "start_tolerance", 0.3, 0.0);
  parameters_.plan_spacing = atLeast(own, "plan_spacing", 0.1, 0.01);
  parameters_.obstacle_tolerance = atLeast(own, "obstacle_tolerance", 0.2, 0.0);
  parameters_.overlay_lifetime = atLeast(own, "overlay_lifetime", 10.0, 1.0);
}

void SocialGlobalPlanner::loadFallback()
{
  if (parameters_.fallback_planner.empty())
    return;
  try
  {
    loader_.reset(
        new pluginlib::ClassLoader<nav_core::BaseGlobalPlanner>("nav_core", "nav_core::BaseGlobalPlanner"));
    fallback_ = loader_->createInstance(parameters_.fallback_planner);
    fallback_->initialize(name_ + "/fallback", costmap_ros_);
  }
  catch (const pluginlib::PluginlibException& error)
  {
    ROS_ERROR("~%s/fallback_planner: %s cannot be loaded, so there is no fallback: %s", name_.c_str(),
              parameters_.fallback_planner.c_str(), error.what());
    fallback_.reset();
  }
}

void SocialGlobalPlanner::hearMap(const nav_msgs::OccupancyGridConstPtr& map)
{
  std::shared_ptr<UnknownObstacles> unknown;
  if (withoutSlash(map->header.frame_id) != frame_)
    ROS_WARN("the map is in frame '%s', the costmap in '%s': its obstacles are not handed on",
             map->header.frame_id.c_str(), frame_.c_str());
  else if (map->data.size() == static_cast<size_t>(map->info.width) * map->info.height && map->info.resolution > 0.0)
    unknown = std::make_shared<UnknownObstacles>(*map, parameters_.obstacle_tolerance);
  std::lock_guard<std::mutex> lock(map_mutex_);
  unknown_ = unknown;
}

bool SocialGlobalPlanner::makePlan(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal,
                                   std::vector<geometry_msgs::PoseStamped>& plan)
{
  double cost;
  return makePlan(start, goal, plan, cost);
}

bool SocialGlobalPlanner::makePlan(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal,
                                   std::vector<geometry_msgs::PoseStamped>& plan, double& cost)
{
  plan.clear();
  cost = 0.0;
  if (costmap_ros_ == nullptr)
  {
    ROS_ERROR("SocialGlobalPlanner has to be initialized before it can plan");
    return false;
  }
  const Answer answer = ask(start, goal, parameters_.default_tolerance, !isNewGoal(goal));
  bool found;
  if (!answer.came)
    found = fallBack(answer.reason, start, goal, plan, cost);
  else if (isTrouble(answer.response.status))
    found = fallBack(answer.response.message, start, goal, plan, cost);
  else
    found = takePath(answer, start.header.stamp, plan, cost);
  publish(plan);
  return found;
}

bool SocialGlobalPlanner::serveMakePlan(nav_msgs::GetPlanRequest& request, nav_msgs::GetPlanResponse& response)
{
  response.plan.header.frame_id = frame_;
  response.plan.header.stamp = ros::Time::now();
  geometry_msgs::PoseStamped start = request.start;
  if (start.header.frame_id.empty() && !costmap_ros_->getRobotPose(start))
  {
    ROS_ERROR("make_plan: where the robot is cannot be had from tf");
    return true;
  }
  const Answer answer = ask(start, request.goal, request.tolerance, true);
  double cost;
  if (answer.came)
    takePath(answer, start.header.stamp, response.plan.poses, cost);
  else
    ROS_WARN_THROTTLE(WARNING_PERIOD, "make_plan: the social planner did not answer: %s", answer.reason.c_str());
  return true;
}

Answer SocialGlobalPlanner::ask(const geometry_msgs::PoseStamped& start, const geometry_msgs::PoseStamped& goal,
                                double tolerance, bool inquiry)
{
  const ros::WallTime deadline = ros::WallTime::now() + ros::WallDuration(parameters_.planner_patience);
  PlanPathRequest request;
  request.robot = parameters_.robot;
  request.start = start;
  request.goal = goal;
  request.tolerance = tolerance;
  request.start_tolerance = parameters_.start_tolerance;
  request.inquiry = inquiry;
  const Obstacles obstacles = unknownObstacles(start.pose.position);
  return client_->ask(request, obstacles, deadline - ros::WallTime::now());
}

Obstacles SocialGlobalPlanner::unknownObstacles(const geometry_msgs::Point& robot)
{
  Obstacles obstacles;
  obstacles.name = "costmap of " + ros::this_node::getName();
  obstacles.robot = parameters_.robot;
  obstacles.frame = frame_;
  obstacles.lifetime = ros::Duration(parameters_.overlay_lifetime);
  std::shared_ptr<UnknownObstacles> unknown;
  {
    std::lock_guard<std::mutex> lock(map_mutex_);
    unknown = unknown_;
  }
  if (!unknown)
    return obstacles;
  costmap_2d::Costmap2D& costmap = *costmap_ros_->getCostmap();
  const double clearance = costmap_ros_->getLayeredCostmap()->getCircumscribedRadius() + 2.0 * costmap.getResolution();
  boost::unique_lock<costmap_2d::Costmap2D::mutex_t> lock(*costmap.getMutex());
  obstacles.cells = unknown->find(costmap, robot, clearance);
  return obstacles;
}

bool SocialGlobalPlanner::takePath(const Answer& answer, const ros::Time& stamp,
                                   std::vector<geometry_msgs::PoseStamped>& plan, double& cost)
{
  plan.clear();
  const PlanPathResponse& response = answer.response;
  if (!answered_)
    ROS_INFO("the social planner answers again");
  answered_ = true;
  if (!answer.reason.empty())
    ROS_WARN_THROTTLE(WARNING_PERIOD, "the path may lead through obstacles: %s", answer.reason.c_str());
  if (response.status != PlanPathResponse::SUCCESS)
  {
    ROS_WARN_THROTTLE(WARNING_PERIOD, "the social planner has no path: %s", response.message.c_str());
    return false;
  }
  if (withoutSlash(response.path.header.frame_id) != frame_)
  {
    ROS_ERROR_THROTTLE(WARNING_PERIOD, "the social planner plans in frame '%s', the costmap is in '%s'",
                       response.path.header.frame_id.c_str(), frame_.c_str());
    return false;
  }
  if (!response.message.empty())
    ROS_INFO("%s", response.message.c_str());
  cost = response.length + response.social_cost;
  for (const geometry_msgs::PoseStamped& pose : response.path.poses)
  {
    // Local planners look at the poses that lie about the robot, so that there have to be some everywhere.
    if (!plan.empty())
    {
      geometry_msgs::PoseStamped between = plan.back();
      const geometry_msgs::Point from = between.pose.position, to = pose.pose.position;
      const int parts = std::ceil(std::hypot(to.x - from.x, to.y - from.y) / parameters_.plan_spacing);
      for (int i = 1; i < parts; ++i)
      {
        between.pose.position.x = from.x + (to.x - from.x) * i / parts;
        between.pose.position.y = from.y + (to.y - from.y) * i / parts;
        plan.push_back(between);
      }
    }
    plan.push_back(pose);
    plan.back().header.frame_id = frame_;
    plan.back().header.stamp = stamp;
  }
  return !plan.empty();
}

bool SocialGlobalPlanner::fallBack(const std::string& why, const geometry_msgs::PoseStamped& start,
                                   const geometry_msgs::PoseStamped& goal,
                                   std::vector<geometry_msgs::PoseStamped>& plan, double& cost)
{
  answered_ = false;
  if (!fallback_)
  {
    ROS_WARN_THROTTLE(WARNING_PERIOD, "no path from the social planner: %s", why.c_str());
    return false;
  }
  ROS_WARN_THROTTLE(WARNING_PERIOD, "no path from the social planner: %s; asking %s instead", why.c_str(),
                    parameters_.fallback_planner.c_str());
  std::lock_guard<std::mutex> lock(fallback_mutex_);
  return fallback_->makePlan(start, goal, plan, cost) && !plan.empty();
}

bool SocialGlobalPlanner::isNewGoal(const geometry_msgs::PoseStamped& goal)
{
  std::lock_guard<std::mutex> lock(goal_mutex_);
  const geometry_msgs::Pose &one = goal.pose, &other = last_goal_;
  const bool same = one.position.x == other.position.x && one.position.y == other.position.y &&
                    one.orientation.z == other.orientation.z && one.orientation.w == other.orientation.w;
  last_goal_ = goal.pose;
  return !same;
}

void SocialGlobalPlanner::publish(const std::vector<geometry_msgs::PoseStamped>& plan)
{
  nav_msgs::Path path;
  path.header.frame_id = frame_;
  path.header.stamp = ros::Time::now();
  path.poses = plan;
  plan_publisher_.publish(path);
}
}  // namespace social_fleet
