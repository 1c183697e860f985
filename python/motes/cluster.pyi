from motes_lab.cluster import *
