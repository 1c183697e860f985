from motes_lab.workloads import *
